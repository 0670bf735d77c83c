"""Whoever loses a contract in a trial has lost it to a fault."""

from __future__ import annotations

import pytest
from trial_kit import TASK, event

from dray.messages import AtvStatus
from dray.messages.fact import AtvStatusChanged, CarrierChanged, GoalLost
from dray.protocol.runtime.shutdown import LEAVES
from dray_sim.checks.broken import InvariantBroken
from dray_sim.checks.fault_attribution import LATER_S, Blame
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

LOST = CarrierChanged(task=TASK, epoch=2, replaced="ATV3", carrier="ATV1", reason="silent")


def test_a_contract_that_is_lost_for_nothing_is_noticed() -> None:
    with pytest.raises(InvariantBroken, match=r"invariant 6 .* ATV3 lost M8-1"):
        Blame().hear(10.0, "M8", "*", event("M8", LOST))


@pytest.mark.parametrize("agent", ["ATV3", "M8", "ATV1"])
def test_a_fault_in_one_of_those_concerned_is_a_reason(agent: str) -> None:
    blame = Blame()
    blame.begin("F1", Crashed(agent), 10.0)
    blame.hear(1000.0, "M8", "*", event("M8", LOST))
    blame.end("F1", 1000.0)
    blame.hear(1000.0 + LATER_S - 1.0, "M8", "*", event("M8", LOST))
    with pytest.raises(InvariantBroken):
        blame.hear(1000.0 + LATER_S, "M8", "*", event("M8", LOST))


def test_a_fault_in_somebody_else_is_none() -> None:
    blame = Blame()
    blame.begin("F1", PoweredOff("ATV5"), 10.0)
    with pytest.raises(InvariantBroken):
        blame.hear(20.0, "M8", "*", event("M8", LOST))


def test_a_stopped_vehicle_may_lose_its_contract() -> None:
    blame = Blame()
    blame.hear(0.0, "ATV3", "*", event("ATV3", AtvStatusChanged(status=AtvStatus.STOPPED)))
    blame.hear(1000.0, "M8", "*", event("M8", LOST))
    blame.hear(1000.0, "ATV3", "*", event("ATV3", AtvStatusChanged(status=AtvStatus.WORKING)))
    blame.hear(1001.0, "M8", "*", event("M8", LOST))


GIVEN_BACK = CarrierChanged(task=TASK, epoch=2, replaced="ATV3", carrier="", reason=LEAVES)


def test_a_vehicle_that_was_asked_to_leave_may_give_its_task_back_and_need_not_be_missed() -> None:
    blame = Blame()
    blame.begin("F1", SentAway("ATV3"), 10.0)
    blame.hear(20.0, "M8", "*", event("M8", GIVEN_BACK))
    with pytest.raises(InvariantBroken, match=r"ATV3 lost M8-1 \(silent\)"):
        blame.hear(20.0, "M8", "*", event("M8", LOST))


def test_whoever_was_not_asked_to_leave_does_not() -> None:
    blame = Blame()
    blame.begin("F1", Crashed("ATV3"), 10.0)
    with pytest.raises(InvariantBroken, match="ATV3 lost M8-1"):
        blame.hear(20.0, "M8", "*", event("M8", GIVEN_BACK))


def test_a_machine_that_is_away_answers_nobody() -> None:
    blame = Blame()
    blame.begin("F1", SentAway("M8"), 10.0)
    blame.hear(60.0, "M8", "*", event("M8", LOST))


def test_a_goal_that_is_lost_for_nothing_is_noticed() -> None:
    lost = GoalLost(goal="D1-1", machine="M8", arrived=0, successor="D1-2")
    blame = Blame()
    blame.begin("F1", Crashed("M8"), 0.0)
    blame.hear(1.0 + COORDINATOR_BACK_S, "strategist", "*", event("strategist", lost))
    with pytest.raises(InvariantBroken, match="M8 lost D1-1"):
        Blame().hear(1.0, "strategist", "*", event("strategist", lost))


@pytest.mark.parametrize(("agent", "back_s"), [("ATV3", VEHICLE_BACK_S), ("M8", COORDINATOR_BACK_S)])
def test_a_process_that_is_back_soon_is_no_reason_and_one_that_is_away_for_longer_is(
    agent: str, back_s: float
) -> None:
    blame = Blame(fleet=("ATV3",))
    blame.begin("F1", Crashed(agent), 10.0)
    blame.end("F1", 10.0 + back_s)
    with pytest.raises(InvariantBroken):
        blame.hear(11.0 + back_s, "M8", "*", event("M8", LOST))
    blame.begin("F2", Crashed(agent), 100.0)
    blame.end("F2", 100.5 + back_s)
    blame.hear(101.0 + back_s, "M8", "*", event("M8", LOST))


def test_crashes_between_which_nothing_can_be_heard_are_one() -> None:
    blame = Blame(fleet=("ATV3",))
    for number, at_s in enumerate((10.0, 11.2, 12.4)):
        blame.begin(f"F{number}", Crashed("ATV3"), at_s)
        blame.end(f"F{number}", at_s + 1.0)
    blame.hear(14.0, "M8", "*", event("M8", LOST))


def test_a_journal_that_is_lost_is_a_reason_and_a_clock_that_was_set_is_none() -> None:
    blame = Blame(fleet=("ATV3",))
    blame.begin("F1", ClockSet("ATV3", 60.0), 10.0)
    with pytest.raises(InvariantBroken):
        blame.hear(20.0, "M8", "*", event("M8", LOST))
    blame.begin("F2", JournalLost("M8"), 20.0)
    blame.end("F2", 20.5)
    blame.hear(21.0, "M8", "*", event("M8", LOST))


def test_what_may_have_lost_a_message() -> None:
    blame = Blame()
    blame.begin("F1", LinkTrouble(sender="ATV1", loss_frac=0.3), 10.0)
    blame.begin("F2", LinkTrouble(sender="M8", latency_s=2.0, jitter_s=1.0), 10.0)
    blame.begin("F3", RadioCut("ATV1"), 10.0)
    assert blame.may_have_lost("ATV1", "M8", 20.0)
    assert not blame.may_have_lost("M8", "ATV1", 20.0)
    assert blame.delay_s(20.0) == 3.0
    blame.end("F1", 30.0)
    assert blame.may_have_lost("ATV1", "M8", 20.0)
    assert not blame.may_have_lost("ATV1", "M8", 31.0)
    blame.begin("F4", WlanCut("M8"), 40.0)
    assert blame.may_have_lost("ATV1", "M8", 41.0)
    assert not blame.may_have_lost("ATV1", "M7", 41.0)


def test_a_process_that_is_sent_away_while_it_is_down_stays_away_as_it_went() -> None:
    blame = Blame(fleet=("ATV3",))
    blame.begin("F1", Crashed("ATV3"), 10.0)
    blame.begin("F2", SentAway("ATV3", 1), 10.0 + VEHICLE_BACK_S / 2.0)
    blame.end("F1", 10.0 + VEHICLE_BACK_S / 2.0 + 0.1)
    blame.hear(10.0 + VEHICLE_BACK_S + 1.0, "M8", "*", event("M8", LOST))


@pytest.mark.parametrize("other", [ClockSet("ATV3", 5.0), Crashed("ATV3")])
def test_a_fault_that_is_none_does_not_keep_an_old_one_alive(other: ClockSet | Crashed) -> None:
    blame = Blame(fleet=("ATV3",))
    blame.begin("F1", WlanCut("ATV3"), 10.0)
    blame.begin("F2", other, 11.0)
    blame.end("F1", 12.0)
    blame.end("F2", 12.5)
    with pytest.raises(InvariantBroken):
        blame.hear(12.0 + LATER_S + 1.0, "M8", "*", event("M8", LOST))
