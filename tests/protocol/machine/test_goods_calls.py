"""Goods on board of a vehicle that has failed: a person is asked to come for them."""

from __future__ import annotations

import msgspec
import pytest
from defaults import PLANT
from effects import committed, published
from left_aboard import GONE_S, KIND, TASK, beats, loaded, run_on, says, stranded, told
from rigs import MachineRig
from spoken import rhb

from dray.body import Broken
from dray.messages import (
    AtvHeartbeat,
    AtvStatus,
    CallAnswer,
    CallAnswered,
    CallState,
    DutyStatus,
    HelpCall,
    MachineCommandKind,
    OperatorHeartbeat,
    Phase,
    Problem,
    ProblemKind,
)
from dray.protocol.calls.call_rules import LATE_S


def calls_of(rig: MachineRig) -> list[HelpCall]:
    """All words on calls for goods, the oldest first."""
    return [call for call in published(rig.all, HelpCall) if call.goods]


def on_duty(rig: MachineRig, operator: str = "operator.A") -> None:
    seq = 1 + int(1000 * rig.now_s)
    beat = OperatorHeartbeat(
        operator=operator,
        incarnation=1,
        seq=seq,
        at_s=rig.now_s,
        status=DutyStatus.FREE,
        everywhere=True,
    )
    rig.on_message(operator, beat)


def test_somebody_is_asked_to_come_to_where_they_are() -> None:
    rig = loaded()
    on_duty(rig)
    while told(rig).stranded is msgspec.UNSET:
        run_on(rig, 5.0)
        on_duty(rig)
    here = PLANT.nodes["a1"]
    call = calls_of(rig)[-1]
    assert (call.goods, call.caller, call.state) == (TASK, "M7", CallState.ASKING)
    assert (call.x_m, call.y_m, call.asked) == (here.x_m, here.y_m, ("operator.A",))
    assert call.problem == Problem(kind=ProblemKind.LOAD, needs_person=True)
    assert call.reason == "24 pump-p3 on board of ATV2"


@pytest.mark.parametrize("kind", [KIND.FETCH_GOODS, KIND.WRITE_OFF])
def test_nobody_is_asked_any_more_once_a_person_has_said_what_becomes_of_them(
    kind: MachineCommandKind,
) -> None:
    rig = stranded()
    on_duty(rig)
    assert calls_of(rig)[-1].state is CallState.ASKING
    assert says(rig, kind) is None
    rig.run(rig.now_s + 1.0)
    assert calls_of(rig)[-1].state is CallState.ENDED
    rig.run(rig.now_s + 60.0)
    assert calls_of(rig)[-1].state is CallState.ENDED


def test_nobody_is_asked_any_more_once_their_vehicle_is_heard_again() -> None:
    rig = stranded()
    assert calls_of(rig)[-1].state is CallState.RESTING
    beats(rig, "ATV2", 2)
    rig.run(rig.now_s + 1.0)
    assert calls_of(rig)[-1].state is CallState.ENDED


def test_others_are_asked_when_who_has_promised_does_not_come() -> None:
    rig = stranded()
    on_duty(rig)
    name = calls_of(rig)[-1].call
    take = CallAnswered(call=name, operator="operator.A", answer=CallAnswer.TAKE, wait_s=60.0)
    rig.on_message("operator.A", take)
    assert calls_of(rig)[-1].taken_by == "operator.A"
    until_s = rig.now_s + 60.0 + LATE_S
    while rig.now_s <= until_s:
        on_duty(rig)
        on_duty(rig, "operator.B")
        run_on(rig, 5.0)
    assert (calls_of(rig)[-1].taken_by, calls_of(rig)[-1].asked) == ("", ("operator.B",))


def test_a_vehicle_that_calls_somebody_itself_is_not_called_for() -> None:
    rig = loaded()
    rig.on_message("ATV2", broken(rig, seq=5))
    rig.run(rig.now_s + 3.0)
    rig.on_message("ATV2", broken(rig, seq=6))
    assert told(rig).stranded is not msgspec.UNSET
    assert calls_of(rig) == []
    run_on(rig, GONE_S)
    assert calls_of(rig)[-1].goods == TASK


def broken(rig: MachineRig, *, seq: int) -> AtvHeartbeat:
    """ATV2 cannot go on, and no time for help is left."""
    said = rhb("ATV2", seq, rig.now_s, task=TASK, coordinator="M7")
    assert said.task is not None
    brief = msgspec.structs.replace(said.task, phase=Phase.CARRYING)
    return msgspec.structs.replace(said, task=brief, status=AtvStatus.ERROR, problem="a wheel")


def test_a_machine_that_is_broken_calls_for_itself_and_for_its_goods() -> None:
    rig = stranded()
    rig.broken = "it stands"
    rig.report(Broken("it stands", Problem(kind=ProblemKind.JAM), resettable=False))
    on_duty(rig)
    newest = {call.subject: call for call in published(rig.all, HelpCall)}
    assert newest.keys() == {("M7", ""), ("M7", TASK)}
    assert len({call.call for call in newest.values()}) == 2
    assert says(rig, KIND.WRITE_OFF) is None
    rig.run(rig.now_s + 1.0)
    newest = {call.subject: call for call in published(rig.all, HelpCall)}
    assert newest["M7", TASK].state is CallState.ENDED
    assert newest["M7", ""].state is CallState.ASKING


def test_the_next_life_of_their_machine_calls_anew() -> None:
    rig = stranded()
    again = MachineRig("M7", rig.stock, incarnation=2)
    again.memory, again.now_s = committed(rig.all), rig.now_s
    again.start()
    on_duty(again)
    again.run(again.now_s + 1.0)
    call = calls_of(again)[-1]
    assert (call.goods, call.incarnation, call.state) == (TASK, 2, CallState.ASKING)
