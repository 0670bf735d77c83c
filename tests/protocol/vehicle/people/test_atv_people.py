"""A vehicle obeys people, and asks them for help."""

from __future__ import annotations

import pytest
from atv1 import command, contracted, last_beat, parked
from effects import facts, instructed, sent
from rigs import VehicleRig
from seals import granted
from spoken import announcement, award

from dray.body import Drive, Hold, LimitSpeed, Pick, ProblemCleared, ProblemRaised, Unhold
from dray.messages import Accepted, AtvStatus, CommandKind, CommandRefusal, Declined, Refusal, VehicleCommand
from dray.messages.fact import BidRefused, CommandObeyed

# --- people's commands ------------------------------------------------------------------------------


def test_a_stop_is_obeyed_at_once_and_answered() -> None:
    rig = contracted()
    answer = command(rig, CommandKind.STOP)
    assert (answer.done, answer.command) == (True, "C1")
    assert len(instructed(rig.all, Hold)) == 1
    assert last_beat(rig).status is AtvStatus.STOPPED
    [obeyed] = facts(rig.all, CommandObeyed)
    assert (obeyed.what, obeyed.done, obeyed.issued_by) == ("stop", True, "shift lead")


def test_a_vehicle_that_is_held_when_it_starts_is_stopped() -> None:
    rig = VehicleRig(battery_frac=0.5)
    rig.held = True
    rig.start()
    [declined] = sent(rig.on_message("M8", award()), Declined)
    assert declined.reason is Refusal.NOT_FIT
    rig.run(60.0)
    assert instructed(rig.all, Drive) == []
    command(rig, CommandKind.ACKNOWLEDGE)
    assert command(rig, CommandKind.RESUME).done
    assert sent(rig.on_message("M8", award()), Accepted)


def test_a_stop_holds_until_an_acknowledge_and_then_a_resume() -> None:
    rig = contracted()
    command(rig, CommandKind.STOP)
    refused = command(rig, CommandKind.RESUME)
    assert (refused.done, refused.reason) == (False, CommandRefusal.NOT_ACKNOWLEDGED)
    assert command(rig, CommandKind.ACKNOWLEDGE).done
    assert instructed(rig.all, Unhold) == []
    assert last_beat(rig).status is AtvStatus.STOPPED
    assert command(rig, CommandKind.RESUME).done
    assert len(instructed(rig.all, Unhold)) == 1
    assert last_beat(rig).status is AtvStatus.WORKING


def test_a_stop_that_comes_again_after_the_resume_stops_nothing() -> None:
    rig = contracted()
    for kind in (CommandKind.STOP, CommandKind.ACKNOWLEDGE, CommandKind.RESUME):
        command(rig, kind)
    assert command(rig, CommandKind.STOP, name="C1").done
    assert len(instructed(rig.all, Hold)) == 1
    assert len(facts(rig.all, CommandObeyed)) == 3
    assert last_beat(rig).status is AtvStatus.WORKING


def test_a_resume_whose_answer_was_lost_is_answered_as_before() -> None:
    rig = contracted()
    for kind in (CommandKind.STOP, CommandKind.ACKNOWLEDGE, CommandKind.RESUME):
        command(rig, kind)
    assert command(rig, CommandKind.RESUME, name="C3").done


def test_commands_of_two_people_are_told_apart_by_who_gave_them() -> None:
    rig = contracted()
    command(rig, CommandKind.STOP)
    acknowledge = VehicleCommand(command="C1", kind=CommandKind.ACKNOWLEDGE)
    rig.on_message("gateway", granted("ATV1", acknowledge, person="operator-north"))
    assert command(rig, CommandKind.RESUME).done


def test_a_second_stop_needs_an_acknowledge_of_its_own() -> None:
    rig = contracted()
    command(rig, CommandKind.STOP)
    command(rig, CommandKind.ACKNOWLEDGE)
    command(rig, CommandKind.STOP)
    assert not command(rig, CommandKind.RESUME).done
    assert instructed(rig.all, Unhold) == []


def test_an_acknowledge_before_the_stop_counts_for_nothing() -> None:
    rig = contracted()
    assert not command(rig, CommandKind.ACKNOWLEDGE).done
    command(rig, CommandKind.STOP)
    assert not command(rig, CommandKind.RESUME).done


def test_what_is_not_stopped_can_be_neither_acknowledged_nor_resumed() -> None:
    rig = contracted()
    for kind in (CommandKind.ACKNOWLEDGE, CommandKind.RESUME):
        answer = command(rig, kind)
        assert (answer.done, answer.reason) == (False, CommandRefusal.NOT_STOPPED)
    assert instructed(rig.all, Unhold) == []


def test_a_fault_that_is_still_there_cannot_be_acknowledged() -> None:
    rig = contracted()
    rig.report(ProblemRaised(reason="the load has shifted"))
    command(rig, CommandKind.STOP)
    refused = command(rig, CommandKind.ACKNOWLEDGE)
    assert (refused.done, refused.reason) == (False, CommandRefusal.FAULTY)
    assert refused.detail == "the load has shifted"
    assert not command(rig, CommandKind.RESUME).done
    rig.report(ProblemCleared())
    assert command(rig, CommandKind.ACKNOWLEDGE).done
    assert command(rig, CommandKind.RESUME).done


def test_a_fault_that_comes_after_the_acknowledge_takes_it_back() -> None:
    rig = contracted()
    for kind in (CommandKind.STOP, CommandKind.ACKNOWLEDGE):
        command(rig, kind)
    rig.report(ProblemRaised(reason="the load has shifted"))
    rig.report(ProblemCleared())
    assert command(rig, CommandKind.RESUME).reason == CommandRefusal.NOT_ACKNOWLEDGED
    assert instructed(rig.all, Unhold) == []


def test_a_stopped_vehicle_tells_whether_it_was_acknowledged() -> None:
    rig = contracted()
    told = []
    for kind in (CommandKind.STOP, CommandKind.ACKNOWLEDGE, CommandKind.RESUME):
        command(rig, kind)
        told.append(last_beat(rig).acknowledged)
    assert told == [False, True, False]


def test_no_message_but_a_resume_moves_a_stopped_vehicle() -> None:
    rig = parked()
    command(rig, CommandKind.STOP)
    rig.held = True
    [declined] = sent(rig.on_message("M8", award()), Declined)
    assert declined.reason is Refusal.NOT_FIT
    [refused] = facts(rig.on_message("M8", announcement()), BidRefused)
    assert refused.reason is Refusal.NOT_FIT
    rig.battery_frac = 0.2
    effects = rig.run(300.0)
    assert instructed(effects, Drive) == instructed(effects, Unhold) == []


def test_a_stop_ends_no_contract() -> None:
    rig = contracted()
    command(rig, CommandKind.STOP)
    beat = last_beat(rig)
    assert beat.task is not None
    assert beat.task.task == "M8-1"
    assert sent(rig.on_message("M8", award()), Accepted)
    command(rig, CommandKind.ACKNOWLEDGE)
    command(rig, CommandKind.RESUME)
    rig.arrive()
    assert len(instructed(rig.all, Pick)) == 1


@pytest.mark.parametrize("speed_frac", [None, 0.0, -0.1, 1.01, float("inf"), float("nan")])
def test_a_speed_outside_of_0_to_1_is_refused(speed_frac: float | None) -> None:
    rig = parked()
    answer = command(rig, CommandKind.SET_SPEED, speed_frac)
    assert not answer.done
    assert answer.reason is CommandRefusal.SPEED_OUT_OF_RANGE
    assert instructed(rig.all, LimitSpeed) == []
    assert last_beat(rig).speed_limit_frac == 1.0


@pytest.mark.parametrize("speed_frac", [0.01, 0.5, 1.0])
def test_a_speed_limit_is_kept_and_told(speed_frac: float) -> None:
    rig = parked()
    assert command(rig, CommandKind.SET_SPEED, speed_frac).done
    assert instructed(rig.all, LimitSpeed) == [LimitSpeed(speed_frac=speed_frac)]
    assert last_beat(rig).speed_limit_frac == speed_frac


def test_a_refused_command_is_a_fact_too() -> None:
    rig = parked()
    command(rig, CommandKind.RESUME)
    [obeyed] = facts(rig.all, CommandObeyed)
    assert (obeyed.done, obeyed.reason) == (False, CommandRefusal.NOT_STOPPED)


# --- problems ---------------------------------------------------------------------------------------


def test_a_vehicle_with_a_problem_is_in_error_says_why_and_takes_nothing() -> None:
    rig = parked()
    rig.report(ProblemRaised(reason="a wheel is stuck"))
    beat = last_beat(rig)
    assert (beat.status, beat.problem) == (AtvStatus.ERROR, "a wheel is stuck")
    [refused] = facts(rig.on_message("M8", announcement()), BidRefused)
    assert (refused.reason, refused.detail) == (Refusal.NOT_FIT, "a wheel is stuck")


def test_a_problem_ends_no_contract_and_work_goes_on_after_it() -> None:
    rig = contracted()
    rig.report(ProblemRaised(reason="a wheel is stuck"))
    rig.report(ProblemCleared())
    beat = last_beat(rig)
    assert (beat.status, beat.problem) == (AtvStatus.WORKING, "")
    rig.arrive()
    assert len(instructed(rig.all, Pick)) == 1


def test_a_stop_is_seen_before_a_problem_and_a_problem_before_work() -> None:
    rig = contracted()
    rig.report(ProblemRaised(reason="a wheel is stuck"))
    assert last_beat(rig).status is AtvStatus.ERROR
    command(rig, CommandKind.STOP)
    assert last_beat(rig).status is AtvStatus.STOPPED
    assert last_beat(rig).problem == "a wheel is stuck"
