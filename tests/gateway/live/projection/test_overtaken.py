"""What panels show of an agent in whose name somebody has once sent a heartbeat of the far future."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from fake_bus import PLANT
from heartbeats import atv_heartbeat, machine_heartbeat, station_heartbeat

from dray.gateway.live.projection import Projection
from dray.gateway.live.projection.agents.people import People
from dray.messages import DutyStatus, OperatorHeartbeat, StrategistHeartbeat
from dray.messages.base import COUNT_MAX
from dray.messages.overtaken import OVERTAKES_S

MACHINE, STORAGE = PLANT.machines[0].id, PLANT.storages[0].id


def strategist_heartbeat(seq: int, **fields: Any) -> StrategistHeartbeat:
    return StrategistHeartbeat(
        **{"strategist": "strategist", "incarnation": 1, "seq": seq, "at_s": 0.0, "orders": 0} | fields
    )


@pytest.mark.parametrize("life", [1, 2], ids=["the same life", "the next life"])
@pytest.mark.parametrize(
    "beat",
    [
        lambda seq, **fields: atv_heartbeat(PLANT.fleet[0].id, seq, **fields),
        lambda seq, **fields: machine_heartbeat(MACHINE, seq, **fields),
        lambda seq, **fields: station_heartbeat(STORAGE, seq, **fields),
        strategist_heartbeat,
    ],
    ids=["a vehicle", "a machine", "a station", "a strategist"],
)
def test_panels_show_the_agent_again(projection: Projection, beat: Callable[..., Any], life: int) -> None:
    def heard(seq: int, at_s: float, life: int = 1) -> bool:
        before = projection.heard
        projection.fold(beat(seq, incarnation=life, at_s=at_s))
        return projection.heard > before

    assert heard(7, 100.0)
    assert heard(COUNT_MAX, 101.0, COUNT_MAX), "a thief's"
    assert not heard(8, 102.0, life)
    assert heard(40, 101.0 + OVERTAKES_S + 0.1, life)
    assert heard(41, 101.0 + OVERTAKES_S + 1.1, life)


def test_panels_show_a_person_again() -> None:
    people = People()

    def heard(seq: int, now_s: float, life: int = 1) -> bool:
        return people.fold(OperatorHeartbeat("operator.A", life, seq, now_s, DutyStatus.FREE), now_s)

    assert heard(7, 100.0)
    assert heard(COUNT_MAX, 101.0, COUNT_MAX), "a thief's"
    assert not heard(8, 102.0)
    assert heard(1, 101.0 + OVERTAKES_S + 0.1, 2)
