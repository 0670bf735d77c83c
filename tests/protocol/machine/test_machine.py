"""A production machine tells how it is, and endures what it is told (paper, 3.2)."""

from __future__ import annotations

from itertools import pairwise

import msgspec
import pytest
from defaults import PLANT
from effects import deeds, facts, published, sent
from m7 import NO_HOUSINGS, m7, status, supplied_by
from msgspec import UNSET
from msgspec.structs import replace
from rigs import MachineRig
from spoken import accepted, bid, goal_bid, mhb, production, rhb

from dray.body import Broken, Repaired, VehicleState
from dray.errors import ProtocolViolation
from dray.messages import (
    BufferLevel,
    CommandKind,
    DwellPointClaimed,
    GoalClosed,
    MachineHeartbeat,
    MachineStatus,
    Release,
    Superseded,
    VehicleCommand,
)
from dray.messages.fact import MachineStatusChanged
from dray.messages.heartbeat_stock import STOCK_EVERY_S, with_stock
from dray.protocol.runtime.events import Reported, Woke

# --- status and heartbeats --------------------------------------------------------------------------


def test_a_machine_without_a_goal_is_idle() -> None:
    rig = m7()
    rig.run(1.0)
    assert status(rig) is MachineStatus.IDLE


def test_a_machine_that_lacks_material_is_starved_and_one_that_has_it_produces() -> None:
    rig = m7(NO_HOUSINGS, goal=2)
    rig.run(1.0)
    assert status(rig) is MachineStatus.STARVED
    rig.stocked("housing", 24)
    rig.run(1.0)
    assert status(rig) is MachineStatus.PRODUCING
    rig.cycles(2)
    rig.run(1.0)
    assert status(rig) is MachineStatus.IDLE


def test_a_broken_machine_says_why() -> None:
    rig = m7(goal=2)
    rig.report(Broken(reason="oil"))
    rig.run(rig.now_s)
    last = rig.heartbeats(MachineHeartbeat)[-1]
    assert (last.status, last.problem) == (MachineStatus.ERROR, "oil")
    rig.report(Repaired())
    rig.run(rig.now_s)
    last = rig.heartbeats(MachineHeartbeat)[-1]
    assert (last.status, last.problem) == (MachineStatus.PRODUCING, "")


def test_every_change_of_status_is_a_fact_with_its_reason() -> None:
    rig = m7(NO_HOUSINGS, goal=1)
    rig.stocked("housing", 1)
    rig.cycle()
    changes = [(fact.status, fact.reason) for fact in facts(rig.all, MachineStatusChanged)]
    assert changes == [
        (MachineStatus.STARVED, "material is missing"),
        (MachineStatus.PRODUCING, ""),
        (MachineStatus.IDLE, ""),
    ]


def test_an_idle_machine_beats_every_five_seconds_and_a_working_one_every_second() -> None:
    idle, working = m7(), m7(goal=24)
    for rig, interval_s in ((idle, 5.0), (working, 1.0)):
        rig.run(60.0)
        rig.all.clear()
        rig.run(120.0)
        times_s = [beat.at_s for beat in rig.heartbeats(MachineHeartbeat)]
        gaps_s = [b - a for a, b in pairwise(times_s)]
        assert gaps_s == pytest.approx([interval_s] * len(gaps_s))
        assert len(gaps_s) >= 60 / interval_s - 2


def test_machines_that_start_together_do_not_beat_together() -> None:
    seconds_s = set()
    for machine in PLANT.machines:
        rig = MachineRig(machine)
        rig.start()
        rig.run(20.0)
        seconds_s.add(round(rig.heartbeats(MachineHeartbeat)[-1].at_s % 5.0, 3))
    assert len(seconds_s) > len(PLANT.machines) / 2


def test_a_change_of_status_is_told_at_once() -> None:
    rig = m7()
    rig.run(12.0)
    rig.now_s = 12.1
    rig.report(Broken(reason="oil"))
    assert rig.agent.wake_at_s <= 12.1
    rig.run(12.1)
    assert rig.heartbeats(MachineHeartbeat)[-1].at_s == 12.1


def test_heartbeats_are_numbered_without_a_gap() -> None:
    rig = m7(goal=3)
    rig.run(30.0)
    beats = rig.heartbeats(MachineHeartbeat)
    assert [beat.seq for beat in beats] == list(range(1, len(beats) + 1))
    assert {beat.incarnation for beat in beats} == {1}


def test_the_heartbeat_names_the_contracted_of_every_open_task() -> None:
    rig = supplied_by("ATV2")
    rig.run(rig.now_s)
    [brief] = rig.heartbeats(MachineHeartbeat)[-1].tasks
    assert (brief.task, brief.epoch, brief.primary, brief.secondary) == ("M7-1", 1, "ATV2", "")
    assert (brief.item, brief.quantity, brief.source, brief.destination) == (
        "housing",
        24,
        "S1",
        "M7",
    )


def test_the_heartbeat_tells_that_the_machine_waits() -> None:
    rig = m7(NO_HOUSINGS, goal=24)
    rig.run(300.0)
    [brief] = rig.heartbeats(MachineHeartbeat)[-1].tasks
    assert brief.primary == ""
    assert brief.round > 5


def test_the_heartbeat_tells_of_buffers_and_goods() -> None:
    rig = m7(goal=24)
    rig.cycles(3)
    rig.run(2.0)
    last = rig.heartbeats(MachineHeartbeat)[-1]
    assert [(level.item, level.level, level.capacity) for level in rig.reported_stock()[0]] == [
        ("housing", 68, 72),
        ("impeller", 86, 90),
        ("seal-kit", 116, 120),
    ]
    assert [(level.item, level.level, level.capacity) for level in rig.reported_stock()[1]] == [
        ("pump-p3", 3, 60)
    ]
    assert last.product == "pump-p3"
    [brief] = last.goals
    assert (brief.made, brief.delivered) == (3, 0)


# --- robustness -------------------------------------------------------------------------------------


def test_what_is_not_meant_for_a_machine_is_ignored() -> None:
    rig = m7(goal=2)
    command = VehicleCommand(command="C1", kind=CommandKind.STOP)
    claim = DwellPointClaimed(dwell_point="CH1", atv="ATV1", battery_frac=0.5, standing=False)
    for message in (
        command,
        claim,
        mhb("M8"),
        rhb("ATV9", 1, 0.0),
        GoalClosed(goal="G9"),
        Superseded(task="M7-1", epoch=2),
        bid(1.0, task="M7-99"),
        goal_bid("G9", 1.0),
    ):
        said = [
            effect
            for effect in deeds(rig.on_message("X", message))
            if not published([effect], MachineHeartbeat)
        ]
        assert said == [], message


def test_an_acceptance_of_an_unknown_task_is_released() -> None:
    rig = m7()
    assert sent(rig.on_message("ATV2", accepted("M7-99")), Release, to="ATV2")


def test_a_machine_without_a_workcell_is_our_own_bug() -> None:
    class Bodyless(MachineRig):
        def sense(self) -> VehicleState:  # type: ignore[override]
            return None  # type: ignore[return-value]

    with pytest.raises(ProtocolViolation, match="needs a workcell"):
        Bodyless("M7").start()


def test_being_woken_for_nothing_is_harmless() -> None:
    rig = m7(goal=24)
    rig.run(10.0)
    rig.now_s = 10.0
    for _ in range(3):
        rig.wake()
    assert rig.wake() == []


def test_an_agent_leaves_what_it_is_told_as_it_is() -> None:
    rig = m7()
    body = rig.sense()
    before = msgspec.json.encode(body)
    rig.agent.handle(Woke(body), 1.0)
    rig.agent.handle(Reported(Broken(reason="oil")), 2.0)
    rig.agent.handle(Reported(Repaired()), 3.0)
    rig.take_goal("G1", production())
    assert msgspec.json.encode(body) == before


def test_what_lies_there_is_told_when_it_changes_and_now_and_then() -> None:
    rig = m7(goal=24)
    rig.run(rig.now_s + 60.0)
    before = len(rig.heartbeats(MachineHeartbeat))
    rig.run(rig.now_s + 3 * STOCK_EVERY_S)
    quiet = rig.heartbeats(MachineHeartbeat)[before:]
    assert len(quiet) >= 3 * STOCK_EVERY_S - 1
    assert [each.buffers is not UNSET for each in quiet].count(True) == 3
    assert all((each.buffers is UNSET) == (each.goods is UNSET) for each in quiet)
    changed = len(rig.heartbeats(MachineHeartbeat))
    rig.cycle()
    rig.run(rig.now_s + 1.0)
    assert any(each.goods is not UNSET for each in rig.heartbeats(MachineHeartbeat)[changed:])


def test_a_heartbeat_that_leaves_out_what_lies_there_is_made_whole_within_one_life() -> None:
    whole = MachineHeartbeat(
        "M7", 1, 1, 0.0, MachineStatus.IDLE, buffers=(BufferLevel("shaft", 3, 9),), goods=()
    )
    brief = MachineHeartbeat("M7", 1, 2, 1.0, MachineStatus.IDLE)
    assert with_stock(brief, whole).buffers == whole.buffers
    assert with_stock(brief, None).buffers is UNSET
    assert with_stock(replace(brief, incarnation=2), whole).buffers is UNSET
