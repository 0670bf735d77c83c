"""Calls for help: who is asked, in which order; who comes; and that no call is lost."""

from __future__ import annotations

from math import hypot, inf, nan

import pytest
from callers import NORTH_M, SOUTH_M, CallerRig, said_of
from defaults import PLANT
from effects import facts

from dray.messages import CallAnswer, CallState, DutyStatus, Problem, ProblemKind
from dray.messages.fact import HelpCallEnded
from dray.messages.people.call import CALL_WAIT_MAX_S
from dray.protocol.calls.call_rules import ANSWER_S, LATE_S, REST_MAX_S, REST_S, SAY_EVERY_S, rest_s
from dray.protocol.calls.help_calls import END_SAID
from dray.protocol.calls.on_duty import GONE_S, SILENT_S

A, B, C, D = (f"operator.{name}" for name in "ABCD")
TAKE, DECLINE, CANNOT = CallAnswer.TAKE, CallAnswer.DECLINE, CallAnswer.CANNOT


@pytest.fixture
def rig() -> CallerRig:
    rig = CallerRig()
    rig.start()
    return rig


def test_the_nearest_who_is_free_is_asked_first_and_alone(rig: CallerRig) -> None:
    rig.beats(A, ("AREA1",), DutyStatus.BUSY)
    rig.beats(B, ("AREA1",))
    rig.beats(C, ("AREA3",))
    rig.open()
    assert (rig.said.state, rig.said.asked, rig.said.round) == (CallState.ASKING, (B,), 1)


def test_a_station_that_is_nearer_goes_before_one_that_is_not(rig: CallerRig) -> None:
    def away_m(station: str) -> float:
        docks = [PLANT.position_of(spec.id) for spec in PLANT.machines.values() if spec.station == station]
        return min(hypot(x_m - NORTH_M[0], y_m - NORTH_M[1]) for x_m, y_m in docks)

    stations = sorted({spec.station for spec in PLANT.machines.values()}, key=away_m)
    rig.beats(A, station=stations[-1])
    rig.beats(B, station=stations[0])
    rig.open()
    assert rig.said.asked == (B,)


def test_who_helps_with_something_else_is_asked_last(rig: CallerRig) -> None:
    rig.beats(A, ("AREA1",), helps_with=(ProblemKind.BATTERY,))
    rig.beats(B, ("AREA4",), helps_with=(ProblemKind.WAY_BLOCKED,))
    rig.open()
    assert rig.said.asked == (B,)


def test_silence_declines_and_the_reach_grows(rig: CallerRig) -> None:
    rig.beats(A)
    rig.beats(B, ("AREA3",))
    rig.beats(C, ("AREA3",), DutyStatus.BUSY)
    rig.open()
    assert rig.said.asked == (A,)
    for operator, areas, status in ((A, ("AREA1",), DutyStatus.FREE), (B, ("AREA3",), DutyStatus.FREE)):
        rig.run(rig.now_s + 10.0)
        rig.beats(operator, areas, status)
    rig.beats(C, ("AREA3",), DutyStatus.BUSY)
    assert (rig.said.asked, rig.said.round) == ((B,), 2)
    rig.run(rig.now_s + 12.0)
    rig.beats(C, ("AREA3",), DutyStatus.BUSY)
    rig.run(rig.now_s + ANSWER_S - 12.0)
    assert (rig.said.asked, rig.said.round) == ((C,), 3)


def test_who_declines_is_not_waited_for(rig: CallerRig) -> None:
    rig.beats(A)
    rig.beats(B)
    rig.open()
    rig.answers(A, DECLINE)
    assert rig.said.asked == (B,)


def test_who_has_a_break_is_not_asked_until_it_is_over(rig: CallerRig) -> None:
    rig.beats(A, status=DutyStatus.BREAK)
    rig.open()
    assert (rig.said.state, rig.said.on_duty) == (CallState.RESTING, 1)
    rig.beats(A)
    assert rig.said.asked == (A,)


def test_where_nobody_is_on_duty_the_call_goes_on_and_says_so(rig: CallerRig) -> None:
    rig.open()
    assert (rig.said.state, rig.said.on_duty, rig.said.asked) == (CallState.RESTING, 0, ())
    said = said_of(rig.run(600.0))
    assert len(said) >= 600.0 / SAY_EVERY_S - 1
    rig.beats(A)
    assert rig.said.asked == (A,), "whoever comes on duty is asked at once"


def test_who_was_not_heard_is_not_asked(rig: CallerRig) -> None:
    rig.beats(A)
    rig.run(SILENT_S + 1.0)
    rig.open()
    assert rig.said.state is CallState.RESTING


def test_one_that_cannot_hear_asks_whom_it_has_heard_last(rig: CallerRig) -> None:
    rig.beats(A)
    rig.run(SILENT_S + 100.0)
    rig.agent.hears_all = False
    rig.open()
    assert rig.said.asked == (A,)
    rig.answers(A, TAKE, 60.0)
    assert rig.said.taken_by == A


def test_who_takes_it_is_told_to_all_and_nobody_else_is_asked(rig: CallerRig) -> None:
    rig.beats(A)
    rig.beats(B)
    rig.open()
    rig.answers(A, TAKE, 60.0)
    said = rig.said
    assert (said.state, said.taken_by, said.turn, said.asked) == (CallState.TAKEN, A, 1, ())
    assert said.until_s == rig.now_s + 60.0
    rig.answers(B, TAKE, 60.0)
    assert (rig.said.taken_by, rig.said.turn) == (A, 1)


def test_who_was_not_asked_may_take_it_too(rig: CallerRig) -> None:
    rig.beats(A)
    rig.beats(B, ("AREA3",), DutyStatus.BUSY)
    rig.open()
    rig.answers(B, TAKE, 60.0)
    assert rig.said.taken_by == B


def test_who_does_not_come_in_time_is_replaced(rig: CallerRig) -> None:
    rig.beats(A)
    rig.open()
    rig.answers(A, TAKE, 60.0)
    rig.passes(60.0 + LATE_S - 1.0, A, B)
    assert rig.said.taken_by == A
    rig.passes(2.0, A, B)
    assert (rig.said.taken_by, rig.said.asked) == ("", (B,))
    rig.answers(B, TAKE, 30.0)
    assert (rig.said.taken_by, rig.said.turn) == (B, 2)


def test_a_promise_may_be_renewed_and_not_for_ever(rig: CallerRig) -> None:
    rig.beats(A)
    rig.open()
    rig.answers(A, TAKE, 60.0)
    rig.passes(50.0, A)
    rig.answers(A, TAKE, 60.0)
    rig.passes(60.0, A)
    assert (rig.said.taken_by, rig.said.turn) == (A, 1)
    for _ in range(40):
        rig.answers(A, TAKE, 60.0)
        rig.passes(55.0, A)
    assert rig.said.turn > 1, "it was asked anew meanwhile"


def test_who_gives_it_back_is_replaced_at_once(rig: CallerRig) -> None:
    rig.beats(A)
    rig.beats(B)
    rig.open()
    rig.answers(A, TAKE, 60.0)
    taken_s = rig.now_s
    rig.answers(A, DECLINE)
    assert (rig.said.taken_by, rig.said.asked) == ("", (B,))
    assert rig.agent.void_since_s == [taken_s]


@pytest.mark.parametrize("silently", [False, True])
def test_who_goes_off_duty_is_replaced(rig: CallerRig, silently: bool) -> None:
    rig.beats(A)
    rig.open()
    rig.answers(A, TAKE, CALL_WAIT_MAX_S)
    if silently:
        rig.passes(GONE_S + SAY_EVERY_S + 5.0, B)
    else:
        rig.beats(A, draining=True)
        rig.beats(B)
    assert (rig.said.taken_by, rig.said.asked) == ("", (B,))


def test_after_all_have_declined_it_rests_and_asks_again_all_but_who_cannot(rig: CallerRig) -> None:
    rig.beats(A)
    rig.beats(B)
    rig.open()
    rig.answers(A, CANNOT)
    rig.answers(B, DECLINE)
    assert rig.said.state is CallState.RESTING
    rig.passes(REST_S, A, B)
    assert rig.said.asked == (B,)


@pytest.mark.parametrize("wait_s", [None, 0.0, -1.0, nan, inf, CALL_WAIT_MAX_S + 1.0])
def test_what_cannot_be_promised_takes_nothing(rig: CallerRig, wait_s: float | None) -> None:
    rig.beats(A)
    rig.open()
    rig.answers(A, TAKE, wait_s)
    assert rig.said.taken_by == ""


def test_a_stranger_and_an_old_call_take_nothing(rig: CallerRig) -> None:
    rig.beats(A)
    rig.open()
    rig.answers("operator.nobody", TAKE, 60.0)
    rig.answers(A, TAKE, 60.0, call="ATV1-1-0")
    assert rig.said.taken_by == ""


def test_the_end_is_said_several_times_and_counted_without_names(rig: CallerRig) -> None:
    rig.beats(A)
    rig.open()
    rig.answers(A, TAKE, 60.0)
    rig.passes(30.0, A)
    effects = rig.close()
    [fact] = facts(effects, HelpCallEnded)
    assert (fact.asked, fact.taken, fact.helped, fact.lasted_s) == (1, 1, True, 30.0)
    assert A not in str(fact)
    said = said_of(effects + rig.run(rig.now_s + 100.0))
    assert [each.state for each in said] == [CallState.ENDED] * END_SAID
    assert not rig.agent.calls.is_open


def test_what_passes_by_itself_calls_nobody(rig: CallerRig) -> None:
    rig.beats(A)
    rig.open(after_s=30.0)
    rig.run(29.0)
    rig.close()
    assert said_of(rig.all + rig.run(200.0)) == []


def test_a_place_in_another_area_is_for_who_is_there_for_it(rig: CallerRig) -> None:
    rig.agent.place_m = SOUTH_M
    there = PLANT.areas_at(*SOUTH_M)
    rig.beats(A, ("AREA1",))
    rig.beats(B, there)
    rig.open()
    assert (rig.said.asked, rig.said.on_duty) == ((B,), 1)


def test_a_call_is_one_however_often_it_is_opened(rig: CallerRig) -> None:
    rig.beats(A)
    rig.open()
    name = rig.said.call
    rig.open(Problem(kind=ProblemKind.DRIVE))
    rig.passes(SAY_EVERY_S, A)
    assert (rig.said.call, rig.said.problem.kind) == (name, ProblemKind.DRIVE)


def test_rests_grow_to_a_bound() -> None:
    assert [rest_s(passes) for passes in (1, 2, 3, 4, 1000)] == [REST_S, 40.0, 80.0, REST_MAX_S, REST_MAX_S]
