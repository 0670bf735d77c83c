"""Whoever loses a contract in a run has lost it to a fault."""

from __future__ import annotations

from contextlib import nullcontext

import pytest
from check_kit import TASK, event

from dray.messages import AtvHeartbeat, AtvStatus, Pose, Reason
from dray.messages.fact import AtvStatusChanged, CarrierChanged, GoalLost
from dray.messages.heartbeat import FloorBrief
from dray_sim.checks.broken import InvariantBroken
from dray_sim.checks.fault_attribution import LATER_S, FaultAttribution
from dray_sim.faults import (
    ClockSet,
    Crashed,
    JournalLost,
    LinkTrouble,
    PoweredOff,
    RadioCut,
    SentAway,
    WlanCut,
)
from dray_sim.faults.chance import COORDINATOR_BACK_S, VEHICLE_BACK_S

LOST = CarrierChanged(task=TASK, epoch=2, replaced="ATV3", carrier="ATV1", reason=Reason.SILENT)


def test_a_contract_that_is_lost_for_nothing_is_noticed() -> None:
    with pytest.raises(InvariantBroken, match=r"invariant 6 .* ATV3 lost M8-1"):
        FaultAttribution().on_message(10.0, "M8", "*", event("M8", LOST))


@pytest.mark.parametrize("agent", ["ATV3", "M8", "ATV1"])
def test_a_fault_in_one_of_those_concerned_is_a_reason(agent: str) -> None:
    attribution = FaultAttribution()
    attribution.begin("F1", Crashed(agent), 10.0)
    attribution.on_message(1000.0, "M8", "*", event("M8", LOST))
    attribution.end("F1", 1000.0)
    attribution.on_message(1000.0 + LATER_S - 1.0, "M8", "*", event("M8", LOST))
    with pytest.raises(InvariantBroken):
        attribution.on_message(1000.0 + LATER_S, "M8", "*", event("M8", LOST))


def test_a_fault_in_somebody_else_is_none() -> None:
    attribution = FaultAttribution()
    attribution.begin("F1", PoweredOff("ATV5"), 10.0)
    with pytest.raises(InvariantBroken):
        attribution.on_message(20.0, "M8", "*", event("M8", LOST))


@pytest.mark.parametrize(("waits_for", "explained"), [("ATV5", True), ("ATV4", False), ("", False)])
def test_a_fault_in_the_vehicle_that_a_carrier_waits_for_is_a_reason(
    waits_for: str, *, explained: bool
) -> None:
    attribution = FaultAttribution()
    attribution.begin("F1", PoweredOff("ATV5"), 10.0)
    heartbeat = AtvHeartbeat(
        atv="ATV3",
        incarnation=1,
        seq=1,
        at_s=20.0,
        status=AtvStatus.WORKING,
        pose=Pose(x_m=0.0, y_m=0.0, heading_rad=0.0),
        node="p1",
        speed_mps=0.0,
        battery_frac=1.0,
        floor=FloorBrief(waits=True, waits_for=waits_for),
    )
    attribution.on_message(20.0, "ATV3", "*", heartbeat)
    with nullcontext() if explained else pytest.raises(InvariantBroken):
        attribution.on_message(21.0, "M8", "*", event("M8", LOST))


def test_a_stopped_vehicle_may_lose_its_contract() -> None:
    attribution = FaultAttribution()
    attribution.on_message(0.0, "ATV3", "*", event("ATV3", AtvStatusChanged(status=AtvStatus.STOPPED)))
    attribution.on_message(1000.0, "M8", "*", event("M8", LOST))
    attribution.on_message(1000.0, "ATV3", "*", event("ATV3", AtvStatusChanged(status=AtvStatus.WORKING)))
    attribution.on_message(1001.0, "M8", "*", event("M8", LOST))


GIVEN_BACK = CarrierChanged(task=TASK, epoch=2, replaced="ATV3", carrier="", reason=Reason.GRACEFUL_SHUTDOWN)


def test_a_vehicle_that_was_asked_to_leave_may_give_its_task_back_and_need_not_be_missed() -> None:
    attribution = FaultAttribution()
    attribution.begin("F1", SentAway("ATV3"), 10.0)
    attribution.on_message(20.0, "M8", "*", event("M8", GIVEN_BACK))
    with pytest.raises(InvariantBroken, match=r"ATV3 lost M8-1 \(silent\)"):
        attribution.on_message(20.0, "M8", "*", event("M8", LOST))


def test_whoever_was_not_asked_to_leave_does_not() -> None:
    attribution = FaultAttribution()
    attribution.begin("F1", Crashed("ATV3"), 10.0)
    with pytest.raises(InvariantBroken, match="ATV3 lost M8-1"):
        attribution.on_message(20.0, "M8", "*", event("M8", GIVEN_BACK))


def test_a_machine_that_is_away_answers_nobody() -> None:
    attribution = FaultAttribution()
    attribution.begin("F1", SentAway("M8"), 10.0)
    attribution.on_message(60.0, "M8", "*", event("M8", LOST))


def test_a_goal_that_is_lost_for_nothing_is_noticed() -> None:
    lost = GoalLost(goal="D1-1", machine="M8", arrived=0, successor="D1-2")
    attribution = FaultAttribution()
    attribution.begin("F1", Crashed("M8"), 0.0)
    attribution.on_message(1.0 + COORDINATOR_BACK_S, "strategist", "*", event("strategist", lost))
    with pytest.raises(InvariantBroken, match="M8 lost D1-1"):
        FaultAttribution().on_message(1.0, "strategist", "*", event("strategist", lost))


@pytest.mark.parametrize(("agent", "back_s"), [("ATV3", VEHICLE_BACK_S), ("M8", COORDINATOR_BACK_S)])
def test_a_process_that_is_back_soon_is_no_reason_and_one_that_is_away_for_longer_is(
    agent: str, back_s: float
) -> None:
    attribution = FaultAttribution(fleet=("ATV3",))
    attribution.begin("F1", Crashed(agent), 10.0)
    attribution.end("F1", 10.0 + back_s)
    with pytest.raises(InvariantBroken):
        attribution.on_message(11.0 + back_s, "M8", "*", event("M8", LOST))
    attribution.begin("F2", Crashed(agent), 100.0)
    attribution.end("F2", 100.5 + back_s)
    attribution.on_message(101.0 + back_s, "M8", "*", event("M8", LOST))


def test_crashes_between_which_nothing_can_be_heard_are_one() -> None:
    attribution = FaultAttribution(fleet=("ATV3",))
    for number, at_s in enumerate((10.0, 11.2, 12.4)):
        attribution.begin(f"F{number}", Crashed("ATV3"), at_s)
        attribution.end(f"F{number}", at_s + 1.0)
    attribution.on_message(14.0, "M8", "*", event("M8", LOST))


def test_a_journal_that_is_lost_is_a_reason_and_a_clock_that_was_set_is_none() -> None:
    attribution = FaultAttribution(fleet=("ATV3",))
    attribution.begin("F1", ClockSet("ATV3", 60.0), 10.0)
    with pytest.raises(InvariantBroken):
        attribution.on_message(20.0, "M8", "*", event("M8", LOST))
    attribution.begin("F2", JournalLost("M8"), 20.0)
    attribution.end("F2", 20.5)
    attribution.on_message(21.0, "M8", "*", event("M8", LOST))


def test_what_may_have_lost_a_message() -> None:
    attribution = FaultAttribution()
    attribution.begin("F1", LinkTrouble(sender="ATV1", loss_frac=0.3), 10.0)
    attribution.begin("F2", LinkTrouble(sender="M8", latency_s=2.0, jitter_s=1.0), 10.0)
    attribution.begin("F3", RadioCut("ATV1"), 10.0)
    assert attribution.may_have_lost("ATV1", "M8", 20.0)
    assert not attribution.may_have_lost("M8", "ATV1", 20.0)
    assert attribution.delay_s(20.0) == 3.0
    attribution.end("F1", 30.0)
    assert attribution.may_have_lost("ATV1", "M8", 20.0)
    assert not attribution.may_have_lost("ATV1", "M8", 31.0)
    attribution.begin("F4", WlanCut("M8"), 40.0)
    assert attribution.may_have_lost("ATV1", "M8", 41.0)
    assert not attribution.may_have_lost("ATV1", "M7", 41.0)


def test_a_process_that_is_sent_away_while_it_is_down_stays_away_as_it_went() -> None:
    attribution = FaultAttribution(fleet=("ATV3",))
    attribution.begin("F1", Crashed("ATV3"), 10.0)
    attribution.begin("F2", SentAway("ATV3", 1), 10.0 + VEHICLE_BACK_S / 2.0)
    attribution.end("F1", 10.0 + VEHICLE_BACK_S / 2.0 + 0.1)
    attribution.on_message(10.0 + VEHICLE_BACK_S + 1.0, "M8", "*", event("M8", LOST))


@pytest.mark.parametrize("other", [ClockSet("ATV3", 5.0), Crashed("ATV3")])
def test_a_fault_that_is_none_does_not_keep_an_old_one_alive(other: ClockSet | Crashed) -> None:
    attribution = FaultAttribution(fleet=("ATV3",))
    attribution.begin("F1", WlanCut("ATV3"), 10.0)
    attribution.begin("F2", other, 11.0)
    attribution.end("F1", 12.0)
    attribution.end("F2", 12.5)
    with pytest.raises(InvariantBroken):
        attribution.on_message(12.0 + LATER_S + 1.0, "M8", "*", event("M8", LOST))
