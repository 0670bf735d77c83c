"""A broken machine calls operators who are on duty, as vehicles do (paper, case 1)."""

from __future__ import annotations

import pytest
from defaults import PLANT
from effects import published
from m7 import m7
from msgspec.structs import replace
from rigs import MachineRig
from seals import granted

from dray.body import Broken, Repaired
from dray.messages import (
    CallAnswer,
    CallAnswered,
    CallState,
    DutyStatus,
    HelpCall,
    HelpWanted,
    MachineCommand,
    MachineCommandKind,
    MachineHeartbeat,
    OperatorHeartbeat,
    Problem,
    ProblemKind,
)
from dray.protocol.calls.call_rules import ANSWER_S
from dray.protocol.people.patience import PASSES_AT_FIRST_S

JAM = Problem(kind=ProblemKind.JAM)
HERE = PLANT.areas_at(*PLANT.position_of("M7"))[0]
ELSEWHERE = next(area for area in PLANT.areas if area != HERE)


def broken(rig: MachineRig, problem: Problem) -> None:
    rig.broken = "it stands"
    rig.report(Broken("it stands", problem, False))


def calls(rig: MachineRig) -> list[HelpCall]:
    return published(rig.all, HelpCall)


def on_duty(rig: MachineRig, operator: str, area: str, *, draining: bool = False) -> None:
    beat = OperatorHeartbeat(
        operator=operator,
        incarnation=1,
        seq=int(rig.now_s) + 1,
        at_s=rig.now_s,
        status=DutyStatus.FREE,
        areas=(area,),
        draining=draining,
    )
    rig.on_message(operator, beat)


def test_a_broken_machine_asks_who_is_on_duty_for_its_place_and_nobody_when_it_works_again() -> None:
    rig = m7(goal=24)
    on_duty(rig, "operator.far", ELSEWHERE)
    on_duty(rig, "operator.near", HERE)
    broken(rig, JAM)
    call = calls(rig)[-1]
    assert (call.caller, call.state, call.asked) == ("M7", CallState.ASKING, ("operator.near",))
    assert (call.problem, call.reason, call.on_duty) == (JAM, "it stands", 1)
    rig.on_message(
        "operator.near",
        CallAnswered(call=call.call, operator="operator.near", answer=CallAnswer.TAKE, wait_s=60.0),
    )
    assert calls(rig)[-1].taken_by == "operator.near"
    rig.broken = ""
    rig.report(Repaired())
    assert calls(rig)[-1].state is CallState.ENDED


def test_a_call_in_which_silence_declines_reaches_further() -> None:
    rig = m7(goal=24)
    on_duty(rig, "operator.far", ELSEWHERE)
    on_duty(rig, "operator.near", HERE)
    broken(rig, JAM)
    rig.run(rig.now_s + ANSWER_S / 2)
    on_duty(rig, "operator.far", ELSEWHERE)
    rig.run(rig.now_s + ANSWER_S / 2 + 0.1)
    assert calls(rig)[-1].asked == ("operator.far",)


def test_out_of_service_or_about_to_leave_it_calls_nobody() -> None:
    rig = m7(goal=24)
    broken(rig, JAM)
    assert calls(rig)[-1].state is CallState.RESTING
    command = MachineCommand(
        command="C1", kind=MachineCommandKind.TAKE_OUT, reason="new bearings", issued_by="Maria"
    )
    rig.on_message("gateway", granted("M7", command))
    assert calls(rig)[-1].state is CallState.ENDED
    other = m7(goal=24)
    broken(other, JAM)
    other.leave()
    assert calls(other)[-1].state is CallState.ENDED


def test_what_passes_by_itself_is_waited_for_before_anybody_is_asked() -> None:
    rig = m7(goal=24)
    broken(rig, Problem(kind=ProblemKind.JAM, passes=True))
    assert not calls(rig)
    rig.run(rig.now_s + PASSES_AT_FIRST_S + 0.1)
    assert calls(rig)


@pytest.mark.parametrize("gone", [False, True], ids=["gives-back", "goes-off-duty"])
def test_goals_wait_no_longer_for_somebody_who_does_not_come(*, gone: bool) -> None:
    rig = m7(goal=24)
    on_duty(rig, "operator.near", HERE)
    broken(rig, JAM)
    judged_s = wanted(rig).until_s
    call = calls(rig)[-1]
    take = CallAnswered(call=call.call, operator="operator.near", answer=CallAnswer.TAKE, wait_s=600.0)
    rig.on_message("operator.near", take)
    promise = MachineCommand(command="C1", kind=MachineCommandKind.PROMISE, wait_s=600.0)
    rig.on_message("gateway", granted("M7", promise))
    assert wanted(rig).until_s > judged_s
    if gone:
        on_duty(rig, "operator.near", HERE, draining=True)
    else:
        rig.on_message("operator.near", replace(take, answer=CallAnswer.DECLINE, wait_s=None))
    assert wanted(rig) == HelpWanted(until_s=judged_s)


def wanted(rig: MachineRig) -> HelpWanted:
    rig.run(rig.now_s + 1.0)
    told = rig.heartbeats(MachineHeartbeat)[-1].help
    assert isinstance(told, HelpWanted)
    return told
