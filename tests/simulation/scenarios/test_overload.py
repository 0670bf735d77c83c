"""More work than the vehicles can carry: what that costs in words, and who is counted."""

from __future__ import annotations

import pytest
from msgspec import structs

from dray.messages import MachineHeartbeat, MachineStatus, StationHeartbeat, WorkSought
from dray.overload import LEAST
from dray.plant import Plant, default_plant
from dray_sim.run.evidence import HELD
from dray_sim.run.observer import Observer
from dray_sim.run.stage import Shift, play

FLEET = ("ATV2", "ATV4")
"""Two that can carry everything."""

MESSAGES_MAX = 140
"""Per transport, in the first hour and a half of an overload. There were 178 when everything was announced again and again."""


@pytest.mark.campaign
def test_an_overload_is_told_and_not_multiplied_by_words() -> None:
    file = default_plant().file
    plant = Plant(structs.replace(file, fleet=tuple(spec for spec in file.fleet if spec.id in FLEET)))
    played = play(Shift(name="overload", duration_s=5400.0, load=0.85), plant, 1)
    report = played.report
    assert report.invariants == HELD
    assert report.transports > 50
    assert report.messages_per_task < MESSAGES_MAX
    assert report.verdict.overloaded_frac > 0.1
    assert report.verdict.overloaded_waiting >= LEAST
    said = f"; overloaded {report.verdict.overloaded_frac:.1%} of the time: up to {report.verdict.overloaded_waiting} transports"
    assert said in report.describe()
    assert played.counts[WorkSought.__name__] > 20


def test_no_heartbeat_counts_as_negotiation() -> None:
    observer = Observer()
    machine = MachineHeartbeat(machine="M1", incarnation=1, seq=1, at_s=0.0, status=MachineStatus.IDLE)
    station = StationHeartbeat(station="S1", incarnation=1, seq=1, at_s=0.0)
    for heartbeat in (machine, station):
        observer.on_message(0.0, "x", "k", heartbeat)
    assert (observer.messages, observer.negotiation) == (2, 0)
