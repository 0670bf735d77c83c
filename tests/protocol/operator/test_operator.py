"""An operator on duty: there as long as the tablet is, asked and never assigned, and busy with one call at a time."""

from __future__ import annotations

from callers import OperatorRig
from effects import published, sent
from msgspec.structs import replace

from dray.body import CallPart, DutyChanged
from dray.messages import CallAnswer, CallAnswered, CallState, DutyStatus, HelpCall, OperatorHeartbeat
from dray.messages.base import COUNT_MAX
from dray.messages.overtaken import OVERTAKES_S
from dray.protocol.liveness.suspicion import IDLE_INTERVAL_S
from dray.protocol.operator.commitment import AGAIN_S, GIVE_UP_S
from dray.protocol.operator.operator import CALL_SILENCE_S, LINGER_S

ME = "operator.A"
TAKE, DECLINE = CallAnswer.TAKE, CallAnswer.DECLINE


def call(number: int = 1, *, caller: str = "ATV1", name: str = "", **said: object) -> HelpCall:
    """A word on a call, by default one that asks this operator."""
    first = HelpCall(
        call=name or f"{caller}-1-1",
        caller=caller,
        incarnation=1,
        number=number,
        at_s=0.0,
        state=CallState.ASKING,
        since_s=0.0,
        asked=(ME,),
    )
    return replace(first, **said)


def taken(number: int, by: str = ME, *, turn: int = 1, until_s: float = 60.0, **said: object) -> HelpCall:
    return call(
        number,
        **{"state": CallState.TAKEN, "taken_by": by, "turn": turn, "until_s": until_s, "asked": (), **said},
    )


def on_duty() -> OperatorRig:
    rig = OperatorRig(ME)
    rig.start()
    rig.run(1.0)
    return rig


def newest(rig: OperatorRig) -> OperatorHeartbeat:
    rig.run(rig.now_s)
    return rig.heartbeats(OperatorHeartbeat)[-1]


# --- being there ------------------------------------------------------------------------------------


def test_somebody_on_duty_beats_and_says_for_what() -> None:
    rig = on_duty()
    rig.run(60.0)
    beats = rig.heartbeats(OperatorHeartbeat)
    assert len(beats) >= 60.0 / IDLE_INTERVAL_S
    assert (beats[-1].status, beats[-1].areas, beats[-1].label) == (DutyStatus.FREE, ("AREA1",), "")


def test_a_break_and_ones_own_word_are_told_at_once() -> None:
    rig = on_duty()
    rig.state = replace(rig.state, on_break=True)
    rig.report(DutyChanged(rig.state))
    assert newest(rig).status is DutyStatus.BREAK
    rig.state = replace(rig.state, on_break=False, busy_until_s=20.0)
    rig.report(DutyChanged(rig.state))
    assert (newest(rig).status, newest(rig).until_s) == (DutyStatus.BUSY, 20.0)
    rig.run(30.0)
    assert newest(rig).status is DutyStatus.FREE


def test_whose_tablet_is_gone_is_there_for_a_while_and_then_says_to_go() -> None:
    rig = on_duty()
    rig.state = replace(rig.state, there=False)
    rig.report(DutyChanged(rig.state))
    rig.run(rig.now_s + LINGER_S - 1.0)
    assert not rig.has_left
    rig.run(rig.now_s + 2.0)
    assert rig.has_left
    assert rig.heartbeats(OperatorHeartbeat)[-1].draining


def test_a_tablet_that_comes_back_in_time_changes_nothing() -> None:
    rig = on_duty()
    for there in (False, True):
        rig.state = replace(rig.state, there=there)
        rig.report(DutyChanged(rig.state))
        rig.run(rig.now_s + LINGER_S - 1.0)
    rig.run(rig.now_s + 2 * LINGER_S)
    assert not rig.has_left


def pocketed(until_s: float) -> OperatorRig:
    """Somebody who has promised to come, and whose tablet is gone."""
    rig = on_duty()
    rig.on_message("ATV1", call())
    rig.replies(call(), TAKE, until_s - rig.now_s)
    rig.on_message("ATV1", taken(2, until_s=until_s))
    rig.state = replace(rig.state, there=False)
    rig.report(DutyChanged(rig.state))
    return rig


def keep_calling(rig: OperatorRig, until_s: float, promised_s: float) -> None:
    number = 2
    while rig.now_s < until_s:
        rig.run(min(until_s, rig.now_s + 5.0))
        number += 1
        rig.on_message("ATV1", taken(number, until_s=promised_s, at_s=rig.now_s))


def test_who_has_promised_is_expected_until_then_though_the_tablet_is_gone() -> None:
    rig = pocketed(300.0)
    keep_calling(rig, 295.0, 300.0)
    assert not rig.has_left
    assert (newest(rig).status, newest(rig).caller) == (DutyStatus.BUSY, "ATV1")
    rig.run(301.0)
    assert rig.has_left
    assert sent(rig.all, CallAnswered)[-1].answer is DECLINE


def test_who_has_no_tablet_and_is_not_needed_any_more_goes() -> None:
    rig = pocketed(300.0)
    keep_calling(rig, 100.0, 300.0)
    rig.on_message("ATV1", call(99, state=CallState.ENDED, asked=()))
    rig.run(102.0)
    assert rig.has_left
    assert rig.heartbeats(OperatorHeartbeat)[-1].draining


def test_who_goes_off_duty_gives_back_what_was_taken() -> None:
    rig = on_duty()
    rig.on_message("ATV1", call())
    rig.replies(call(), TAKE, 60.0)
    rig.on_message("ATV1", taken(2))
    effects = rig.leave()
    assert [each.answer for each in sent(effects, CallAnswered)] == [DECLINE]
    assert published(effects, OperatorHeartbeat)[-1].draining
    assert rig.shown == {}


# --- being asked ------------------------------------------------------------------------------------


def test_who_is_asked_sees_it_and_who_is_not_does_not() -> None:
    rig = on_duty()
    rig.on_message("ATV1", call(1, asked=("operator.B",)))
    assert rig.shown == {}
    rig.on_message("ATV1", call(2))
    assert rig.shown == {"ATV1-1-1": CallPart.ASKED}
    rig.on_message("ATV1", call(3, asked=()))
    assert rig.shown == {}


def test_what_is_taken_is_said_until_the_caller_confirms() -> None:
    rig = on_duty()
    rig.on_message("ATV1", call())
    rig.replies(call(), TAKE, 60.0)
    assert rig.shown == {"ATV1-1-1": CallPart.TAKING}
    effects = rig.run(rig.now_s + 2.5 * AGAIN_S)
    assert len(sent(effects, CallAnswered, to="ATV1")) == 2
    assert rig.agent.taken is None
    rig.on_message("ATV1", taken(2))
    assert rig.shown == {"ATV1-1-1": CallPart.TAKEN}
    assert rig.agent.taken == ("ATV1-1-1", 1)
    assert (newest(rig).status, newest(rig).caller) == (DutyStatus.BUSY, "ATV1")
    assert not sent(rig.run(rig.now_s + 20.0), CallAnswered)


def test_what_nobody_confirms_is_given_back_and_the_person_decides_again() -> None:
    rig = on_duty()
    rig.on_message("ATV1", call())
    rig.replies(call(), TAKE, 60.0)
    effects = rig.run(rig.now_s + GIVE_UP_S + AGAIN_S)
    assert sent(effects, CallAnswered)[-1].answer is DECLINE
    assert newest(rig).status is DutyStatus.FREE


def test_nobody_is_assigned() -> None:
    rig = on_duty()
    rig.on_message("ATV1", call())
    rig.replies(call(), DECLINE)
    effects = rig.on_message("ATV1", taken(2))
    assert [each.answer for each in sent(effects, CallAnswered, to="ATV1")] == [DECLINE]
    assert rig.agent.taken is None


def test_nobody_has_two_calls() -> None:
    rig = on_duty()
    rig.on_message("ATV1", call())
    rig.on_message("ATV2", call(caller="ATV2"))
    rig.replies(call(), TAKE, 60.0)
    assert not sent(rig.replies("ATV2-1-1", TAKE, 60.0), CallAnswered, to="ATV2")
    rig.on_message("ATV1", taken(2))
    effects = rig.on_message("ATV2", taken(2, caller="ATV2"))
    assert [each.answer for each in sent(effects, CallAnswered, to="ATV2")] == [DECLINE]
    assert rig.agent.taken == ("ATV1-1-1", 1)


def test_what_another_one_has_taken_is_not_shown_any_more() -> None:
    rig = on_duty()
    rig.on_message("ATV1", call())
    rig.replies(call(), TAKE, 60.0)
    rig.on_message("ATV1", taken(2, by="operator.B"))
    assert rig.shown == {}
    assert newest(rig).status is DutyStatus.FREE


def test_who_was_replaced_is_free_again() -> None:
    rig = on_duty()
    rig.on_message("ATV1", call())
    rig.replies(call(), TAKE, 60.0)
    rig.on_message("ATV1", taken(2))
    rig.on_message("ATV1", call(3, asked=("operator.B",)))
    assert rig.agent.taken is None
    assert newest(rig).status is DutyStatus.FREE


def test_an_overtaken_word_changes_nothing() -> None:
    rig = on_duty()
    rig.on_message("ATV1", call())
    rig.replies(call(), TAKE, 60.0)
    rig.on_message("ATV1", taken(5))
    rig.on_message("ATV1", call(3, asked=()))
    assert rig.agent.taken == ("ATV1-1-1", 1)


def test_a_call_with_a_number_of_the_far_future_does_not_shut_out_its_caller_for_ever() -> None:
    rig = on_duty()
    rig.on_message("ATV1", call())
    rig.on_message("ATV1", call(COUNT_MAX, state=CallState.ENDED))
    rig.on_message("ATV1", call(2))
    assert rig.shown == {}, "a thief has ended it"
    rig.run(rig.now_s + OVERTAKES_S + 0.1)
    rig.on_message("ATV1", call(9))
    assert list(rig.shown) == ["ATV1-1-1"]


def test_a_call_that_is_not_said_any_more_binds_nobody() -> None:
    rig = on_duty()
    rig.on_message("ATV1", call())
    rig.replies(call(), TAKE, 60.0)
    rig.on_message("ATV1", taken(2))
    rig.run(rig.now_s + CALL_SILENCE_S + 1.0)
    assert rig.agent.taken is None
    assert rig.shown == {}


def test_a_call_is_forgotten_at_the_very_moment_for_which_the_operator_wanted_to_be_woken() -> None:
    rig, heard_s = on_duty(), 236.828
    assert (heard_s + CALL_SILENCE_S) - heard_s < CALL_SILENCE_S, "rounded down"
    rig.run(heard_s)
    rig.on_message("ATV1", call())
    rig.run(heard_s + CALL_SILENCE_S)
    assert rig.shown == {}


def test_what_was_promised_holds_for_the_callers_next_life() -> None:
    rig = on_duty()
    rig.on_message("ATV1", call())
    rig.replies(call(), TAKE, 60.0)
    rig.on_message("ATV1", taken(2))
    rig.run(rig.now_s + 10.0)
    again = call(1, name="ATV1-2-1", incarnation=2, asked=("operator.B",))
    [said] = sent(rig.on_message("ATV1", again), CallAnswered)
    assert (said.call, said.answer) == ("ATV1-2-1", TAKE)
    assert 45.0 < (said.wait_s or 0.0) < 60.0


def test_ones_own_next_life_keeps_what_was_promised() -> None:
    rig = OperatorRig(ME, incarnation=2)
    rig.start()
    rig.on_message("ATV1", taken(2))
    assert rig.agent.taken == ("ATV1-1-1", 1)


def test_a_promise_anew_is_said_until_it_is_confirmed() -> None:
    rig = on_duty()
    rig.on_message("ATV1", call())
    rig.replies(call(), TAKE, 60.0)
    rig.on_message("ATV1", taken(2))
    rig.replies(call(), TAKE, 300.0)
    rig.on_message("ATV1", taken(3, until_s=50.0))
    assert rig.shown == {"ATV1-1-1": CallPart.TAKING}
    rig.on_message("ATV1", taken(4, until_s=300.0))
    assert rig.shown == {"ATV1-1-1": CallPart.TAKEN}
    assert rig.agent.taken == ("ATV1-1-1", 1)


def test_the_end_of_a_call_frees_who_has_it() -> None:
    rig = on_duty()
    rig.on_message("ATV1", call())
    rig.replies(call(), TAKE, 60.0)
    rig.on_message("ATV1", taken(2))
    rig.on_message("ATV1", call(3, state=CallState.ENDED, asked=()))
    assert rig.agent.taken is None
    assert newest(rig).status is DutyStatus.FREE
