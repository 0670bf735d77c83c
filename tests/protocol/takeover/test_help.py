"""A vehicle in trouble: its task waits for as long as it, or whoever helps it, says."""

from __future__ import annotations

import pytest
from effects import facts, published, sent
from rigs import VehicleRig
from seals import granted
from spoken import award
from watches import BOUND_S, beat, carrying, claims, guard, newest

from dray.body import ProblemCleared, ProblemRaised
from dray.messages import (
    AtvStatus,
    CallAnswer,
    CallAnswered,
    CommandAnswered,
    CommandKind,
    DutyStatus,
    HelpCall,
    HelpWanted,
    OperatorHeartbeat,
    Reason,
    VehicleCommand,
)
from dray.messages.fact import HelpAsked, HelpPromised, TookOver
from dray.protocol.people.patience import PATIENCE_MAX_S, PATIENCE_MIN_S


def test_a_primary_in_trouble_is_waited_for_as_long_as_it_says() -> None:
    rig = guard()
    for seq in range(2, 63):
        rig.run(float(seq - 1))
        beat(rig, seq, status=AtvStatus.ERROR, problem="way blocked", help=HelpWanted(until_s=60.0))
    [took] = facts(rig.all, TookOver)
    assert claims(rig)[0].reason is Reason.IN_ERROR
    assert took.silent_s < BOUND_S


def test_a_vehicle_with_a_problem_says_how_long_its_task_can_wait() -> None:
    rig = carrying()
    rig.report(ProblemRaised(reason="way blocked"))
    heartbeat = newest(rig)
    assert heartbeat.status is AtvStatus.ERROR
    assert heartbeat.help == HelpWanted(until_s=PATIENCE_MAX_S)
    [asked] = facts(rig.all, HelpAsked)
    assert (asked.task, asked.reason) == ("M8-1", "way blocked")
    rig.report(ProblemCleared())
    assert newest(rig).help is None
    assert newest(rig).status is AtvStatus.WORKING


def test_a_vehicle_that_a_person_has_stopped_lets_its_task_wait_and_asks_for_nobody_by_that() -> None:
    rig = carrying()
    rig.on_message("operator", granted("ATV1", VehicleCommand(command="C1", kind=CommandKind.STOP)))
    heartbeat = newest(rig)
    assert (heartbeat.status, heartbeat.help) == (AtvStatus.STOPPED, HelpWanted(until_s=PATIENCE_MAX_S))
    assert facts(rig.all, HelpAsked) == []
    rig.report(ProblemRaised(reason="way blocked"))
    [asked] = facts(rig.all, HelpAsked)
    assert (asked.reason, asked.until_s) == ("way blocked", PATIENCE_MAX_S)


def test_a_task_that_is_late_already_waits_a_little_all_the_same() -> None:
    rig = VehicleRig()
    rig.start()
    # A deadline that it can just keep.
    rig.on_message("M8", award(deadline_s=90.0))
    rig.run(80.0)
    rig.report(ProblemRaised(reason="way blocked"))
    help_wanted = newest(rig).help
    assert help_wanted is not None
    assert PATIENCE_MIN_S <= help_wanted.until_s - rig.now_s < PATIENCE_MAX_S


def test_an_idle_vehicle_with_a_problem_keeps_nobody_waiting() -> None:
    rig = VehicleRig()
    rig.start()
    rig.report(ProblemRaised(reason="way blocked"))
    assert newest(rig).help is None


def promise(rig: VehicleRig, wait_s: float | None) -> CommandAnswered:
    command = VehicleCommand(
        command="C1", kind=CommandKind.PROMISE, wait_s=wait_s, issued_by="operator north"
    )
    [answer] = sent(rig.on_message("operator-north", granted("ATV1", command)), CommandAnswered)
    return answer


def test_a_promise_holds_the_takeover_back() -> None:
    rig = carrying()
    rig.report(ProblemRaised(reason="way blocked"))
    assert promise(rig, 240.0).done
    assert newest(rig).help == HelpWanted(until_s=240.0, promised_by="operator north")
    assert [fact.until_s for fact in facts(rig.all, HelpPromised)] == [240.0]


@pytest.mark.parametrize("wait_s", [None, 0.0, -1.0, 1e9, float("nan")])
def test_a_promise_that_says_no_time_is_refused(wait_s: float | None) -> None:
    rig = carrying()
    rig.report(ProblemRaised(reason="way blocked"))
    answer = promise(rig, wait_s)
    assert not answer.done
    assert answer.reason
    assert newest(rig).help == HelpWanted(until_s=PATIENCE_MAX_S)


def test_a_promise_without_trouble_is_refused() -> None:
    assert not promise(carrying(), 60.0).done


def test_a_stop_lets_the_task_wait_too_and_a_resume_ends_that() -> None:
    rig = carrying()
    for kind, wanted in (
        (CommandKind.STOP, True),
        (CommandKind.ACKNOWLEDGE, True),
        (CommandKind.RESUME, False),
    ):
        rig.on_message("operator", granted("ATV1", VehicleCommand(command=kind.value, kind=kind)))
        assert (newest(rig).help is not None) is wanted


def takes(rig: VehicleRig, answer: CallAnswer, wait_s: float | None = None) -> None:
    """The only one on duty answers the newest call."""
    name = published(rig.all, HelpCall)[-1].call
    said = CallAnswered(call=name, operator="operator.A", answer=answer, wait_s=wait_s)
    rig.on_message("operator.A", said)


def promised(rig: VehicleRig, name: str, wait_s: float) -> None:
    promise = VehicleCommand(command=name, kind=CommandKind.PROMISE, wait_s=wait_s)
    rig.on_message("gateway", granted("ATV1", promise))


def called() -> VehicleRig:
    """ATV1 cannot go on, and one operator is on duty."""
    rig = carrying()
    there = OperatorHeartbeat(
        operator="operator.A", incarnation=1, seq=1, at_s=0.0, status=DutyStatus.FREE, everywhere=True
    )
    rig.on_message("operator.A", there)
    rig.report(ProblemRaised(reason="way blocked"))
    return rig


@pytest.mark.parametrize("answer", [CallAnswer.DECLINE, CallAnswer.CANNOT])
def test_a_task_waits_no_longer_for_somebody_who_gives_the_call_back(answer: CallAnswer) -> None:
    rig = called()
    judged = newest(rig).help
    takes(rig, CallAnswer.TAKE, 600.0)
    promised(rig, "C1", 600.0)
    assert newest(rig).help == HelpWanted(until_s=rig.now_s + 600.0, promised_by="shift-lead")
    takes(rig, answer)
    assert newest(rig).help == judged


def test_what_somebody_else_has_promised_before_holds() -> None:
    rig = called()
    promised(rig, "C1", 600.0)
    rig.run(1.0)
    takes(rig, CallAnswer.TAKE, 60.0)
    takes(rig, CallAnswer.DECLINE)
    assert newest(rig).help == HelpWanted(until_s=600.0, promised_by="shift-lead")
