"""In the quiet phase at the end of a run everything has to come to its end."""

from __future__ import annotations

import msgspec
import pytest
from check_kit import PLANT, TASK, closed, event, heartbeat, opened
from makings import making

from dray.messages import (
    CancellationTaken,
    Message,
    OrderReleased,
    Refusal,
    RevocationTaken,
    Role,
    StationHeartbeat,
    StockLevel,
    TransportOrdered,
    TransportState,
    TransportWait,
)
from dray.messages.fact import BidRefused, Fact, MemoryLost, OrderFulfilled, PieceMade, TransportProgressed
from dray.protocol.people.patience import PATIENCE_MAX_S
from dray_sim.checks.bounds import NOTICE_S, Bounds
from dray_sim.checks.broken import InvariantBroken
from dray_sim.checks.liveness import LivenessCheck
from dray_sim.people.habits import Habits


class Watched:
    """A check with a clock of its own."""

    def __init__(self, habits: Habits | None = None) -> None:
        self.bounds = Bounds(PLANT, habits)
        self.liveness = LivenessCheck(self.bounds)
        self.now_s = 0.0

    def say(self, sender: str, said: Fact | Message) -> None:
        message = event(sender, said) if isinstance(said, Fact) else said
        assert isinstance(message, Message)
        self.liveness.on_message(self.now_s, sender, "*", message)

    def wait(self, seconds: float) -> None:
        """Let time pass; M1 makes pieces of something else all the while."""
        until_s = self.now_s + seconds
        while self.now_s < until_s:
            self.now_s = min(self.now_s + 5.0, until_s)
            self.say("M1", heartbeat("ATV8"))


def test_before_faults_have_ended_nothing_is_asked() -> None:
    watched = Watched()
    watched.say("M8", opened())
    watched.wait(10_000.0)
    assert not watched.liveness.over.is_set()


def test_a_task_that_nobody_serves_is_noticed() -> None:
    watched = Watched()
    watched.say("M8", opened())
    watched.wait(100.0)
    watched.liveness.start(watched.now_s)
    bound_s = watched.bounds.task_s("shaft", 0)
    watched.wait(bound_s - 10.0)
    with pytest.raises(InvariantBroken, match="M8-1 did not end"):
        watched.wait(20.0)


def test_a_task_waits_longer_while_others_are_served() -> None:
    watched = Watched()
    watched.liveness.start(0.0)
    watched.say("M8", opened())
    for number in range(8):
        watched.wait(watched.bounds.transport_s / 4)
        watched.say("M2", opened(f"M2-{number}"))
        watched.say("M2", closed(f"M2-{number}"))
    assert watched.now_s > watched.bounds.transport_s
    with pytest.raises(InvariantBroken, match="M8-1 did not end"):
        watched.wait(watched.bounds.task_s("shaft", 8))


def test_an_order_for_which_nothing_happens_is_noticed() -> None:
    watched = Watched()
    watched.say("desk", OrderReleased(order="D1", items=(), due_s=0.0))
    watched.liveness.start(0.0)
    watched.wait(watched.bounds.stall_s - 10.0)
    watched.say("M1", PieceMade(goal="D1-1", product="pump-p3", made=1))
    watched.wait(watched.bounds.stall_s - 10.0)
    with pytest.raises(InvariantBroken, match=r"nothing came forward .* D1"):
        watched.wait(20.0)


def test_transports_that_are_asked_for_and_called_off_bring_nothing_forward() -> None:
    watched = Watched()
    watched.say("desk", OrderReleased(order="D1", items=(), due_s=0.0))
    watched.liveness.start(0.0)
    watched.wait(watched.bounds.stall_s - 10.0)
    called_off = TransportProgressed("M5-away-1", TransportState.CANCELLED, "pump-p3", 6, "M5", "S1")
    watched.say("S1", called_off)
    with pytest.raises(InvariantBroken, match=r"nothing came forward .* D1"):
        watched.wait(20.0)


def test_what_a_machine_has_forgotten_to_have_asked_for_needs_nothing() -> None:
    watched = Watched()
    watched.say("M5", TransportOrdered("M5-away-1", "M5", "pump-p3", 6, 300.0))
    watched.say("M1", TransportOrdered("M1-away-1", "M1", "pump-p3", 6, 300.0))
    watched.liveness.start(0.0)
    watched.say("M5", MemoryLost("the disk has failed"))
    with pytest.raises(InvariantBroken, match=r"nothing came forward .* open: M1-away-1$"):
        watched.wait(watched.bounds.stall_s + 10.0)


def full(watched: Watched, *, machine: str = "M5", room: int = 0) -> None:
    """Two storages, the second one with some room, and parts that lie unneeded at a machine; the first one answers."""
    watched.say("S1", StationHeartbeat("S1", 1, 1, 0.0, stocks=(StockLevel("pump-p3", 10, 10),)))
    watched.say("S2", StationHeartbeat("S2", 1, 1, 0.0, stocks=(StockLevel("pump-p3", 25 - room, 25),)))
    watched.say(machine, TransportOrdered("M5-away-1", "M5", "pump-p3", 5, 300.0))
    waiting = TransportState.WAITING
    told = TransportProgressed("M5-away-1", waiting, "pump-p3", 5, "M5", "S1", wait=TransportWait.NO_ROOM)
    watched.say("S1", told)


def test_parts_for_which_no_storage_has_room_may_stay_at_their_machine() -> None:
    watched = Watched()
    watched.liveness.start(0.0)
    full(watched, room=4)
    watched.wait(10.0)
    assert watched.liveness.over.is_set()
    watched.say("desk", OrderReleased(order="D1", items=(), due_s=0.0))
    watched.wait(10.0)
    assert not watched.liveness.over.is_set()


def test_parts_for_which_another_storage_has_room_must_come_there() -> None:
    watched = Watched()
    watched.liveness.start(0.0)
    full(watched, room=5)
    with pytest.raises(InvariantBroken, match=r"nothing came forward .* M5-away-1"):
        watched.wait(watched.bounds.stall_s + 10.0)


def test_what_people_have_called_for_must_come_or_be_called_off() -> None:
    watched = Watched()
    watched.liveness.start(0.0)
    full(watched, machine="desk")
    with pytest.raises(InvariantBroken, match=r"nothing came forward .* M5-away-1"):
        watched.wait(watched.bounds.stall_s + 10.0)


def test_parts_that_find_room_later_must_be_fetched() -> None:
    watched = Watched()
    watched.liveness.start(0.0)
    full(watched)
    watched.wait(10.0)
    undecided = TransportProgressed("M5-away-1", TransportState.WAITING, "pump-p3", 5, "M5", "S1")
    watched.say("S1", undecided)
    watched.wait(10.0)
    assert not watched.liveness.over.is_set()


def test_the_check_is_over_when_everything_has_ended() -> None:
    watched = Watched()
    watched.say("desk", OrderReleased(order="D1", items=(), due_s=0.0))
    watched.say("M8", opened())
    watched.say("strategist", opened("D1-1", making("pump-p3", 1, "D1")))
    watched.liveness.start(0.0)
    watched.wait(10.0)
    assert not watched.liveness.over.is_set()
    watched.say("M8", closed())
    watched.wait(10.0)
    assert not watched.liveness.over.is_set()
    watched.say("strategist", OrderFulfilled(order="D1"))
    watched.wait(10.0)
    assert watched.liveness.over.is_set()


def test_an_order_that_is_cancelled_needs_nothing_any_more() -> None:
    watched = Watched()
    released = OrderReleased(order="D1", items=(), due_s=0.0)
    watched.say("desk", released)
    watched.liveness.start(0.0)
    watched.say("strategist", CancellationTaken(order="D1"))
    watched.say("desk", released)
    watched.wait(10.0)
    assert watched.liveness.over.is_set()


def test_an_order_that_is_taken_back_needs_nothing_until_it_is_released_again() -> None:
    watched = Watched()
    released = OrderReleased(order="D1", items=(), due_s=0.0)
    watched.say("desk", released)
    watched.liveness.start(0.0)
    watched.say("strategist", RevocationTaken("D1", 1, (3,)))
    watched.say("desk", released)
    watched.wait(10.0)
    assert watched.liveness.over.is_set()
    watched.say("revoker", msgspec.structs.replace(released, release=2))
    watched.say("strategist", RevocationTaken("D1", 1, (3,)))
    watched.wait(10.0)
    assert not watched.liveness.over.is_set()
    watched.say("strategist", OrderFulfilled(order="D1"))
    watched.wait(10.0)
    assert watched.liveness.over.is_set()


def test_a_vehicle_that_works_on_for_nobody_is_noticed() -> None:
    watched = Watched()
    watched.liveness.start(0.0)
    watched.say("M8", opened())
    watched.say("M8", closed())
    watched.say("ATV2", heartbeat("ATV2", TASK))
    watched.wait(100.0)
    assert not watched.liveness.over.is_set()
    with pytest.raises(InvariantBroken, match="ATV2 still works for M8-1"):
        watched.wait(watched.bounds.settle_s + watched.bounds.transport_s)


def test_a_vehicle_that_ends_its_work_is_free() -> None:
    watched = Watched()
    watched.liveness.start(0.0)
    watched.say("M8", opened())
    watched.say("M8", closed())
    watched.say("ATV2", heartbeat("ATV2", TASK))
    watched.say("ATV2", heartbeat("ATV2"))
    watched.wait(10.0)
    assert watched.liveness.over.is_set()


def test_people_make_everything_slower() -> None:
    alone, helped = Bounds(PLANT, None), Bounds(PLANT, Habits())
    assert alone.settle_s == NOTICE_S + PATIENCE_MAX_S
    assert helped.settle_s > alone.settle_s
    assert helped.transport_s == alone.transport_s
    assert helped.stall_s - alone.stall_s == pytest.approx(helped.settle_s - alone.settle_s)


def test_a_task_for_few_vehicles_may_wait_longer() -> None:
    bounds = Bounds(PLANT, None)
    kinds = [PLANT.vehicle_types[spec.type] for spec in PLANT.fleet.values()]
    assert any("pallet" not in kind.abilities for kind in kinds)
    assert bounds.task_s("housing", 0) == bounds.task_s("shaft", 0)
    assert bounds.task_s("housing", 5) > bounds.task_s("shaft", 5)


def test_while_a_vehicle_must_charge_all_may_take_longer_and_no_longer_than_that() -> None:
    watched = Watched()
    watched.liveness.start(0.0)
    watched.say("desk", OrderReleased(order="D1", items=(), due_s=0.0))
    watched.say(
        "ATV2",
        BidRefused(task="M8-1", epoch=1, role=Role.PRIMARY, reason=Refusal.BATTERY, detail="must charge"),
    )
    assert 0.0 < watched.bounds.must_charge_s < 4.0 * watched.bounds.stall_s
    watched.wait(watched.bounds.stall_s + watched.bounds.must_charge_s - 10.0)
    with pytest.raises(InvariantBroken, match="nothing came forward"):
        watched.wait(20.0)
