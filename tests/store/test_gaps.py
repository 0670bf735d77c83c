"""Gaps in agents' numbered histories: what is noticed, what is asked for, and when it is given up."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import pairwise

from dray.messages import EventsAsked, EventsKept
from dray.messages.base import COUNT_MAX
from dray.messages.history import EVENTS_PER_ANSWER, HISTORY_KEPT, LIVES_TOLD, LifeKept
from dray.messages.overtaken import OVERTAKES_S
from dray.store.history.gaps import (
    AGAIN_S,
    ASKED_AT_ONCE,
    LIVES,
    MISSING_MAX,
    SETTLE_S,
    SILENCE_S,
    TAIL_S,
    Gaps,
    Known,
)


def note(gaps: Gaps, *numbers: int, agent: str = "M1", life: int = 1, now_s: float = 0.0) -> Gaps:
    for number in numbers:
        gaps.note(agent, life, number, now_s)
    return gaps


def kept(
    first: int,
    last: int,
    life: int = 1,
    said_in: int | None = None,
    earlier: Iterable[tuple[int, int, int]] | None = None,
) -> EventsKept:
    lives = None if earlier is None else tuple(LifeKept(*each) for each in earlier)
    return EventsKept(incarnation=life, first=first, last=last, life=said_in or life, earlier=lives)


def missing(gaps: Gaps) -> set[int]:
    """The missing numbers of M1's lives."""
    return {number for life in gaps._tellers["M1"].lives.values() for number in life.missing}


def asked(gaps: Gaps, now_s: float) -> list[tuple[int, int, int]]:
    """What M1 is asked now: life, first and last number."""
    return [
        (question.incarnation, question.first, question.last)
        for agent, question in gaps.due(now_s)
        if agent == "M1"
    ]


# --- what is missing -------------------------------------------------------------------------------


def test_numbers_in_order_leave_no_gap() -> None:
    assert note(Gaps(), 1, 2, 2, 3).missing == 0


def test_a_skipped_number_is_missing_until_it_comes() -> None:
    gaps = note(Gaps(), 3)
    assert gaps.missing == 2
    note(gaps, 1, 1)
    assert gaps.missing == 1
    note(gaps, 2)
    assert (gaps.missing, gaps.gone) == (0, 0)


def test_a_new_life_counts_from_one_and_late_numbers_of_the_old_one_still_count() -> None:
    gaps = note(Gaps([Known("M1", 1, 50)]), 51)
    note(gaps, 1, life=2)
    assert gaps.missing == 0
    note(gaps, 53)
    assert gaps.missing == 1
    note(gaps, 52)
    assert gaps.missing == 0


def test_numbers_are_looked_for_to_a_bound_and_gone_beyond() -> None:
    gaps = note(Gaps(), 3 * HISTORY_KEPT + 1)
    assert (gaps.missing, gaps.gone) == (HISTORY_KEPT, 2 * HISTORY_KEPT)
    note(gaps, 4 * HISTORY_KEPT + 2)
    assert (gaps.missing, gaps.gone) == (HISTORY_KEPT, 3 * HISTORY_KEPT)
    note(gaps, 2**53)
    assert gaps.missing == HISTORY_KEPT


def test_what_is_known_from_before_may_have_holes() -> None:
    gaps = Gaps([Known("M1", 1, 5, (2, 3))])
    assert gaps.missing == 2
    note(gaps, 2)
    assert asked(gaps, 0.0) == [(1, 3, 3)]


def test_whoever_listens_beside_is_told_of_what_was_missed() -> None:
    gaps = Gaps()
    assert not gaps.note("M1", 1, 1, 0.0)
    assert not gaps.note("M1", 1, 4, 0.0)
    assert gaps.note("M1", 1, 2, 0.0)
    assert not gaps.note("M1", 1, 2, 0.0)
    assert asked(gaps, SETTLE_S) == [(1, 3, 3)]
    assert gaps.note("M1", 1, 5, 1.1)
    gaps.answered("M1", kept(1, 5), 1.2)
    assert not gaps.note("M1", 1, 6, 1.3)


# --- what is asked ---------------------------------------------------------------------------------


def test_a_skipped_number_is_asked_for_when_it_is_not_just_late() -> None:
    gaps = note(Gaps(), 1, 4, now_s=10.0)
    assert asked(gaps, 10.0 + SETTLE_S / 2) == []
    assert asked(gaps, 10.0 + SETTLE_S) == [(1, 2, 3)]


def test_nobody_is_asked_twice_before_the_pause_is_over_and_pauses_grow_to_a_bound() -> None:
    gaps = note(Gaps(), 2)
    moments_s = [now_s / 2 for now_s in range(1000) if asked(gaps, now_s / 2)]
    pauses_s = [later - before for before, later in pairwise(moments_s)]
    assert pauses_s[:5] == [2.0, 4.0, 8.0, 16.0, 32.0]
    assert set(pauses_s[5:]) == {AGAIN_S[1]}


def test_a_question_is_no_wider_than_an_answer() -> None:
    gaps = note(Gaps(), 3, EVENTS_PER_ANSWER * 3)
    assert asked(gaps, SETTLE_S) == [(1, 1, EVENTS_PER_ANSWER)]


def test_an_answer_that_helps_is_followed_by_the_next_question_at_once() -> None:
    gaps = note(Gaps(), EVENTS_PER_ANSWER * 2)
    asked(gaps, 1.0)
    note(gaps, *range(1, EVENTS_PER_ANSWER + 1), now_s=1.1)
    assert gaps.answered("M1", kept(1, EVENTS_PER_ANSWER * 2), 1.2) == 0
    assert asked(gaps, 1.2) == [(1, EVENTS_PER_ANSWER + 1, EVENTS_PER_ANSWER * 2 - 1)]


def test_an_answer_that_does_not_help_is_asked_again_later() -> None:
    gaps = note(Gaps(), 3)
    asked(gaps, 1.0)
    gaps.answered("M1", kept(1, 3), 1.2)
    # The first answer has at least told how far that life goes.
    assert asked(gaps, 1.2) == [(1, 1, 2)]
    gaps.answered("M1", kept(1, 3), 1.4)
    assert asked(gaps, 2.0) == []
    assert asked(gaps, 1.4 + 2 * AGAIN_S[0]) == [(1, 1, 2)]


def test_an_agent_that_seems_to_lack_nothing_is_asked_now_and_then_for_what_comes_next() -> None:
    gaps = note(Gaps(), 1, 2)
    assert asked(gaps, SETTLE_S) == [(1, 3, 2 + EVENTS_PER_ANSWER)]
    gaps.answered("M1", kept(1, 2), 1.1)
    assert asked(gaps, 1.0 + TAIL_S) == []
    assert asked(gaps, 1.1 + TAIL_S) == [(1, 3, 2 + EVENTS_PER_ANSWER)]


def test_a_last_event_that_was_lost_is_learnt_of_and_asked_for() -> None:
    gaps = note(Gaps(), 1)
    asked(gaps, 1.0)
    # The answer has come, the events before it have not.
    gaps.answered("M1", kept(1, 3), 1.1)
    assert gaps.missing == 2
    assert asked(gaps, 1.1) == [(1, 2, 3)]


def test_an_agent_that_was_heard_but_has_told_nothing_is_asked_from_the_beginning() -> None:
    gaps = Gaps()
    gaps.note_alive("M1", 1, 0.0)
    assert asked(gaps, SETTLE_S) == [(1, 1, EVENTS_PER_ANSWER)]


def test_an_agent_that_was_never_heard_before_is_asked_for_its_earlier_lives_too() -> None:
    gaps = note(Gaps(), 1, life=3)
    lives: list[int] = []
    for _ in range(3):
        ((life, _, _),) = asked(gaps, SETTLE_S)
        lives.append(life)
        gaps.answered("M1", kept(1, int(life == 3), life=life, said_in=3), SETTLE_S)
    assert lives == [1, 2, 3]


def test_lives_between_two_that_are_known_are_asked_about() -> None:
    gaps = Gaps([Known("M1", 1, 3), Known("M1", 3, 3)])
    gaps.answered("M1", kept(1, 3, life=1, said_in=3), 0.0)
    assert asked(gaps, 0.0) == [(2, 1, EVENTS_PER_ANSWER)]


def test_who_is_known_by_name_only_is_asked_too_and_tells_which_life_it_is_in() -> None:
    gaps = Gaps([Known("M2", 3, 1)], agents=["M1", "M2"])
    assert asked(gaps, 0.0) == [(1, 1, EVENTS_PER_ANSWER)]
    gaps.answered("M1", kept(1, 0, life=1, said_in=2), 0.1)
    assert asked(gaps, 0.1) == [(2, 1, EVENTS_PER_ANSWER)]
    gaps.answered("M1", kept(1, 4, life=2), 0.2)
    assert gaps.missing == 4


def test_what_came_while_nobody_listened_is_asked_for_first_of_all() -> None:
    gaps = Gaps([Known("M1", 1, 17)], now_s=5.0)
    assert asked(gaps, 5.0) == [(1, 18, 17 + EVENTS_PER_ANSWER)]


def test_not_all_agents_are_asked_at_once() -> None:
    gaps = Gaps(Known(f"A{number}", 1, 1) for number in range(3 * ASKED_AT_ONCE))
    first = [agent for agent, _ in gaps.due(0.0)]
    assert len(first) == ASKED_AT_ONCE
    assert gaps.due(0.1) == []
    for agent in first:
        gaps.answered(agent, kept(1, 1), 0.5)
    second = [agent for agent, _ in gaps.due(0.5)]
    assert len(second) == ASKED_AT_ONCE
    assert not set(first) & set(second)


def test_agents_that_do_not_answer_do_not_keep_others_from_being_asked() -> None:
    gaps = Gaps(Known(f"A{number}", 1, 1) for number in range(10 * ASKED_AT_ONCE))
    seen = {agent for now_s in range(60) for agent, _ in gaps.due(float(now_s))}
    assert len(seen) == 10 * ASKED_AT_ONCE


def test_an_agent_that_is_back_after_a_silence_is_asked_at_once() -> None:
    gaps = note(Gaps(), 2)
    quiet_s = 0.0
    while quiet_s < 1000.0:  # pauses have grown to their bound
        quiet_s += 1.0
        gaps.due(quiet_s)
    back_s = quiet_s + SILENCE_S + 1.0
    gaps.note_alive("M1", 1, back_s)
    assert asked(gaps, back_s) == []
    assert asked(gaps, back_s + SETTLE_S) == [(1, 1, 1)]


# --- what is gone ----------------------------------------------------------------------------------


def test_what_an_agent_keeps_no_longer_is_gone() -> None:
    gaps = note(Gaps(), 10)
    assert gaps.answered("M1", kept(4, 10), 1.0) == 3
    assert (gaps.missing, gaps.gone) == (6, 3)


def test_an_agent_that_has_told_nothing_yet_has_lost_nothing() -> None:
    gaps = note(Gaps(), 3)
    # Said before it told its first, and late.
    assert gaps.answered("M1", kept(1, 0), 1.0) == 0
    assert gaps.missing == 2


def test_of_a_life_that_is_over_and_forgotten_everything_missing_is_gone() -> None:
    gaps = note(Gaps(), 3)
    note(gaps, 1, life=2)
    assert asked(gaps, SETTLE_S) == [(1, 1, 2)]
    assert gaps.answered("M1", kept(1, 0, life=1, said_in=2), 1.1) == 2
    assert (gaps.missing, gaps.gone) == (0, 2)
    assert asked(gaps, 1.1) == [(2, 2, 1 + EVENTS_PER_ANSWER)]


# --- lives -----------------------------------------------------------------------------------------


def test_the_end_of_a_life_is_asked_for_when_the_next_one_is_heard() -> None:
    gaps = note(Gaps(), 1, 2)
    asked(gaps, SETTLE_S)
    gaps.answered("M1", kept(1, 2), 1.1)
    gaps.note_alive("M1", 2, 5.0)
    assert asked(gaps, 5.0 + SETTLE_S) == [(1, 3, 2 + EVENTS_PER_ANSWER)]
    note(gaps, 3, 4, now_s=6.1)
    gaps.answered("M1", kept(1, 4, life=1, said_in=2), 6.2)
    # That life is over: nothing more can come of it.
    assert asked(gaps, 6.2) == [(2, 1, EVENTS_PER_ANSWER)]
    gaps.answered("M1", kept(1, 0, life=2), 6.3)
    assert [life for life, _, _ in asked(gaps, 6.3 + TAIL_S)] == [2]


def test_lives_that_nobody_has_heard_of_are_asked_about() -> None:
    gaps = Gaps([Known("M1", 1, 3)])
    gaps.note_alive("M1", 3, 0.0)
    lives: list[int] = []
    now_s = 1.0
    for _ in range(3):
        ((life, _, _),) = asked(gaps, now_s)
        lives.append(life)
        gaps.answered("M1", kept(1, 3 if life == 1 else 0, life=life, said_in=3), now_s)
    assert lives == [1, 2, 3]


def test_only_so_many_lives_are_followed() -> None:
    gaps = note(Gaps(), 3)
    gaps.note_alive("M1", 100, 1.0)
    assert (gaps.missing, gaps.gone) == (0, 2)
    assert asked(gaps, 2.0) == [(100 - LIVES + 1, 1, EVENTS_PER_ANSWER)]


def test_lives_that_began_and_ended_while_nobody_listened_are_asked_for_however_soon_the_next_ones_begin() -> (
    None
):
    # As in a run with a kill every few seconds: the historian had heard lives 3, 5 and 6, and was killed.
    gaps = Gaps([Known("M11", 3, 109), Known("M11", 5, 3), Known("M11", 6, 106, tuple(range(1, 104)))])
    gaps.note("M11", 8, 102, 1.0)
    gaps.note_alive("M11", 10, 2.0)
    lives = {3: 109, 4: 101, 5: 94, 6: 123, 7: 82, 8: 133, 9: 138, 10: 3}
    fetched: dict[int, set[int]] = {life: set() for life in lives}
    for second in range(3, 300):
        for agent, question in gaps.due(float(second)):
            life = question.incarnation
            last = lives.get(life, 0)
            told = range(question.first, min(last, question.last) + 1)
            fetched.setdefault(life, set()).update(told)
            note(gaps, *told, agent=agent, life=life, now_s=float(second))
            gaps.answered(agent, kept(1, last, life=life, said_in=10), float(second))
    assert fetched[4] == set(range(1, 102))
    assert fetched[5] >= set(range(4, 95))
    assert (gaps.missing, gaps.gone) == (0, 0)


def test_an_answer_reveals_lives_that_nobody_has_heard_of_and_closes_those_that_are_whole() -> None:
    gaps = Gaps([Known("M1", 1, 3), Known("M1", 2, 5), Known("M1", 7, 4)])
    assert asked(gaps, 0.0) == [(1, 4, 3 + EVENTS_PER_ANSWER)]
    gaps.answered("M1", kept(1, 3, said_in=7, earlier=[(1, 1, 3), (2, 1, 5), (4, 3, 9)]), 0.1)
    assert asked(gaps, 0.1) == [(4, 3, 9)]
    note(gaps, *range(3, 10), life=4, now_s=0.2)
    gaps.answered("M1", kept(3, 9, life=4, said_in=7, earlier=[(1, 1, 3), (2, 1, 5), (4, 3, 9)]), 0.2)
    assert asked(gaps, 0.3) == [(7, 5, 4 + EVENTS_PER_ANSWER)]
    assert gaps.missing == 0


def test_an_end_that_was_lost_is_asked_for_when_a_later_answer_tells_of_it() -> None:
    gaps = note(Gaps(), 1, 2)
    gaps.answered("M1", kept(1, 2), 0.1)
    gaps.note_alive("M1", 2, 1.0)
    gaps.answered("M1", kept(1, 0, life=2, earlier=[(1, 1, 4)]), 1.1)
    assert missing(gaps) == {3, 4}
    assert asked(gaps, 2.0) == [(1, 3, 4)]


def test_lives_that_were_deleted_are_not_fetched_once_more() -> None:
    gaps = Gaps([Known("M1", 5, 9, is_first_asked=True), Known("M1", 6, 2)])
    gaps.answered("M1", kept(1, 2, life=6, earlier=[(3, 1, 8), (4, 1, 8), (5, 1, 9)]), 0.1)
    assert gaps.missing == 0
    assert asked(gaps, 0.2) == []


def test_no_agent_has_more_lives_or_numbers_followed_than_the_bounds() -> None:
    gaps = Gaps()
    for life in range(1, 3 * LIVES):
        note(gaps, HISTORY_KEPT, life=life)
    assert len(gaps._tellers["M1"].lives) <= LIVES
    assert gaps.missing <= MISSING_MAX
    lives = [(life, 1, HISTORY_KEPT // LIVES_TOLD) for life in range(200, 200 + LIVES_TOLD)]
    gaps.answered("M1", kept(1, 0, life=COUNT_MAX, earlier=lives), 0.1)
    assert len(gaps._tellers["M1"].lives) <= LIVES
    assert gaps.missing <= MISSING_MAX


def test_an_answer_that_names_more_than_an_agent_keeps_tells_nothing_of_earlier_lives() -> None:
    gaps = note(Gaps(), 1, 3)
    gaps.answered("M1", kept(1, 0, life=9, earlier=[(2, 1, HISTORY_KEPT), (3, 1, 1)]), 0.1)
    gaps.answered("M1", kept(1, 0, life=9, earlier=[(2, 2, 1)]), 0.1)
    assert missing(gaps) == {2}


def test_whatever_is_lost_all_that_is_kept_arrives_in_the_end() -> None:
    """An agent of three lives, and a network that loses two of three messages, in a fixed pattern."""
    histories = {1: 40, 2: 0, 3: 300}
    gaps, arrived = Gaps(), set[tuple[int, int]]()
    sent = 0

    def comes_through() -> bool:
        nonlocal sent
        sent += 1
        return sent * 7 % 3 == 0 or sent % 5 == 0

    def tell(life: int, numbers: Iterable[int], now_s: float) -> None:
        for number in numbers:
            if comes_through():
                arrived.add((life, number))
                gaps.note("M1", life, number, now_s)

    def answer(question: EventsAsked, now_s: float) -> None:
        life, last = question.incarnation, histories.get(question.incarnation, 0)
        tell(life, range(max(1, question.first), min(last, question.last) + 1), now_s)
        if comes_through():
            gaps.answered("M1", kept(1, last, life=life, said_in=3), now_s)

    for life, last in histories.items():
        tell(life, range(1, last + 1), 0.0)
    for now_s in range(1, 1000):
        gaps.note_alive("M1", 3, float(now_s))
        for _, question in gaps.due(float(now_s)):
            if comes_through():
                answer(question, float(now_s))
    assert arrived == {(life, number) for life, last in histories.items() for number in range(1, last + 1)}
    assert (gaps.missing, gaps.gone) == (0, 0)


# --- what a thief of an agent's certificate tells ----------------------------------------------------


def test_a_life_of_the_far_future_does_not_keep_its_owners_history_out_for_ever() -> None:
    gaps = note(Gaps(), 1, 2, life=3)
    note(gaps, 1, life=COUNT_MAX, now_s=10.0)
    note(gaps, 4, life=3, now_s=11.0)
    assert gaps.missing == 0, "perhaps it came late"
    now_s = 10.0 + OVERTAKES_S + 0.1
    note(gaps, 6, life=3, now_s=now_s)
    gaps.answered("M1", kept(1, 6, life=3), now_s + SETTLE_S)
    note(gaps, 8, life=3, now_s=now_s + 2.0)
    assert 7 in missing(gaps)


def test_a_life_that_goes_on_is_not_replaced_by_a_late_word_of_an_earlier_one() -> None:
    gaps = note(Gaps(), 1, life=99)
    for now_s in (20.0, 40.0, 60.0):
        gaps.note_alive("M1", 99, now_s)
        note(gaps, 5, life=1, now_s=now_s)
    note(gaps, 3, life=99, now_s=61.0)
    assert gaps.missing == 1


def test_a_number_of_the_far_future_does_not_hide_later_gaps_for_ever() -> None:
    gaps = note(Gaps(), 1, 2, 3)
    note(gaps, COUNT_MAX)
    assert asked(gaps, SETTLE_S)
    gaps.answered("M1", kept(1, 3), 2.0)
    assert gaps.missing == 0
    note(gaps, 5, now_s=3.0)
    assert missing(gaps) == {4}


def test_for_a_number_of_the_far_future_no_number_that_is_kept_stays_unsought() -> None:
    gaps = note(Gaps(), 1, 2, 5)
    note(gaps, COUNT_MAX)
    gaps.answered("M1", kept(1, 7), 2.0)
    assert missing(gaps) == {3, 4, 5, 6, 7}, "at worst, one is fetched once more"


def test_an_agent_is_followed_in_the_life_it_says_it_is_in_though_a_thief_has_named_the_next_one() -> None:
    gaps = note(Gaps([Known("M1", 3, 1, is_first_asked=True)]), 1, life=4)
    now_s = OVERTAKES_S + 1.0
    for later_s in (0.0, 1.0):
        gaps.note_alive("M1", 3, now_s + later_s)
        gaps.answered("M1", kept(1, 1, life=3), now_s + later_s)
    assert asked(gaps, now_s + 1.0 + SETTLE_S) == []


def test_what_is_told_while_an_answer_is_under_way_is_at_worst_fetched_once_more() -> None:
    gaps = note(Gaps(), 1, 2, 5)
    assert asked(gaps, SETTLE_S) == [(1, 3, 4)]
    note(gaps, 3, 4, 6, now_s=SETTLE_S)
    gaps.answered("M1", kept(1, 5), SETTLE_S)
    note(gaps, 7, now_s=2.0)
    assert missing(gaps) == {6}
    note(gaps, 6, now_s=3.0)
    assert (gaps.missing, gaps.gone) == (0, 0)
