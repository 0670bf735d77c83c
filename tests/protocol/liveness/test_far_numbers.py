"""What one message with a number of the far future costs: its sender is unheard for a while, and is heard again then."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from defaults import KEYS, PLANT
from effects import instructed
from msgspec.structs import replace
from spoken import mhb, rhb

from dray.body import CloseDock
from dray.memory import DepartureMemory
from dray.messages import DutyStatus, OperatorHeartbeat, StrategistHeartbeat
from dray.messages.base import COUNT_MAX
from dray.messages.overtaken import OVERTAKES_S
from dray.protocol.calls.on_duty import OnDuty
from dray.protocol.liveness.failure_detector import FailureDetector, HeartbeatSubscriptions
from dray.protocol.liveness.suspicion import WORKING_INTERVAL_S
from dray.protocol.runtime.life import Life
from dray.protocol.strategist.machine_monitor import MachineMonitor
from dray.protocol.strategist.order_book import OrderBook
from dray.protocol.strategist.peers import PEER_SILENCE_S, Peers
from dray.protocol.transports.bookings import Bookings
from dray.protocol.transports.visits import Visits

Hears = Callable[[int, int, float], object]
"""Called with the life and the number of a heartbeat, and the present time; true if the heartbeat counts."""


def of_a_carrier() -> Hears:
    detector = FailureDetector("ATV1", WORKING_INTERVAL_S, 0.0)
    return lambda life, seq, now_s: detector.on_heartbeat(
        replace(rhb("ATV1", seq, now_s), incarnation=life), now_s
    )


def of_a_machine() -> Hears:
    monitor = MachineMonitor(PLANT)
    monitor.start(0.0)
    return lambda life, seq, now_s: monitor.on_heartbeat(
        replace(mhb("M1", seq=seq, at_s=now_s), incarnation=life), now_s
    )


def of_a_person() -> Hears:
    on_duty = OnDuty()
    return lambda life, seq, now_s: on_duty.note(
        OperatorHeartbeat("operator.A", life, seq, now_s, DutyStatus.FREE), now_s
    )


def of_a_strategist() -> Hears:
    peers = Peers(("strategist2",), KEYS, Life("strategist"), OrderBook(PLANT, lambda _work: (), ""))
    peers.start(0.0)

    def hears(life: int, seq: int, now_s: float) -> bool:
        peers.on_heartbeat("strategist2", StrategistHeartbeat("strategist2", life, seq, now_s, 0), now_s)
        return not peers.is_silent("strategist2", now_s + PEER_SILENCE_S - 0.01)

    return hears


def of_a_vehicle_that_leaves() -> Hears:
    life_of = Life("M7")
    heard = HeartbeatSubscriptions(KEYS.atv_heartbeat, life_of)
    visits = Visits(PLANT.node_of("M7"), heard, Bookings(life_of), life_of)

    def hears(life: int, seq: int, now_s: float) -> bool:
        visits.restore([DepartureMemory("ATV1")])
        life_of.effects.clear()
        visits.on_vehicle(replace(rhb("ATV1", seq, now_s), incarnation=life), now_s)
        return bool(instructed(life_of.effects, CloseDock))

    return hears


@pytest.mark.parametrize("life", [1, 2], ids=["the same life", "the next life"])
@pytest.mark.parametrize(
    "rig", [of_a_carrier, of_a_machine, of_a_person, of_a_strategist, of_a_vehicle_that_leaves]
)
def test_a_heartbeat_of_the_far_future_does_not_shut_out_its_owner_for_ever(
    rig: Callable[[], Hears], life: int
) -> None:
    hears = rig()
    assert hears(1, 7, 100.0)
    assert hears(COUNT_MAX, COUNT_MAX, 101.0), "a thief's"
    assert not hears(life, 8, 102.0)
    assert hears(life, 40, 101.0 + OVERTAKES_S + 0.1)
    assert hears(life, 41, 101.0 + OVERTAKES_S + 1.1)
    assert not hears(life, 41, 101.0 + OVERTAKES_S + 1.2)
