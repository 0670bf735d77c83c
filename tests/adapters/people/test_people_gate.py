"""What people say at the gate counts once, and no more than is admitted: twice, too much, far off, of a shut goal, over lives of its agent."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dray.adapters.people.gate import DAMAGED_GATE, KeptGate, PeopleGate
from dray.body import Admit, GoodsArrived, Report, Word, WordTaken
from dray.messages import CommandRefusal, MachineCommandKind

KIND, REFUSED = MachineCommandKind, CommandRefusal
GOAL = "order-7-1.1"


class Bench:
    """A gate whose disk outlives its agent."""

    def __init__(self, admitted: int = 12, kept_goals: int = 10) -> None:
        self.kept: KeptGate | None = None
        self.reports: list[Report] = []
        self._most = kept_goals
        self.begin()
        self.body.instruct(Admit(GOAL, admitted))

    def begin(self) -> None:
        self.body = PeopleGate(self, self.kept, self._most)
        self.body.attach(self.reports.append)

    def remember(self, kept: KeptGate) -> None:
        self.kept = kept

    def says(
        self, pieces: int, key: str, goal: str = GOAL, *, sure: bool = False
    ) -> tuple[CommandRefusal | None, str]:
        self.body.instruct(Word(key, KIND.ARRIVED, goal, pieces, sure=sure))
        taken = self.reports[-1]
        assert isinstance(taken, WordTaken)
        return taken.refused, taken.detail

    @property
    def arrived(self) -> int:
        return self.body.sense().arrived[GOAL]


def test_pieces_are_told_when_people_say_that_they_have_arrived() -> None:
    bench = Bench()
    assert bench.reports == [GoodsArrived(GOAL, 0, 12, by_people=True)]
    assert bench.says(12, "w1") == (None, "")
    assert bench.reports[1] == GoodsArrived(GOAL, 12, 12, by_people=True)
    assert bench.body.sense().people


def test_a_word_that_comes_again_counts_once_in_any_life() -> None:
    bench = Bench()
    for _ in range(3):
        assert bench.says(5, "w1", sure=True) == (None, "")
        bench.begin()
    assert bench.arrived == 5


def test_more_than_is_admitted_is_asked_once_and_never_counts() -> None:
    bench = Bench()
    assert bench.says(13, "w1") == (REFUSED.UNLIKELY, "12")
    assert bench.says(13, "w2", sure=True) == (REFUSED.NOT_ADMITTED, "12")
    assert bench.arrived == 0


def test_far_fewer_than_are_to_come_is_asked_once_unless_the_last_load_was_like_it() -> None:
    bench = Bench(100)
    assert bench.says(10, "w1") == (REFUSED.UNLIKELY, "100")
    assert bench.says(10, "w2", sure=True) == (None, "")
    assert bench.says(12, "w3") == (None, "")
    assert bench.arrived == 22


@pytest.mark.parametrize("goal", [GOAL, "of nobody"])
def test_of_a_goal_that_is_shut_or_unknown_nothing_counts(goal: str) -> None:
    bench = Bench()
    bench.body.instruct(Admit(GOAL, 0))
    assert bench.says(1, "w1", goal, sure=True) == (REFUSED.NOT_ADMITTED, "")
    assert bench.arrived == 0


@pytest.mark.parametrize("pieces", [0, -4])
def test_no_pieces_are_no_word(pieces: int) -> None:
    bench = Bench()
    assert bench.says(pieces, "w1", sure=True) == (REFUSED.QUANTITY_OUT_OF_RANGE, "")


def test_a_finished_goal_is_forgotten_before_one_that_is_open() -> None:
    bench = Bench(kept_goals=2)
    bench.body.instruct(Admit("done", 1))
    bench.says(1, "w1", "done")
    bench.body.instruct(Admit("new", 1))
    assert set(bench.body.sense().arrived) == {GOAL, "new"}


def test_after_damage_its_agent_tells_what_is_in_and_people_go_on_with_what_is_to_come() -> None:
    bench = Bench()
    assert bench.says(5, "w1", sure=True) == (None, "")
    bench.kept = DAMAGED_GATE
    bench.begin()
    bench.reports.clear()
    bench.body.instruct(Admit(GOAL, 12, arrived=5))
    assert bench.reports == [GoodsArrived(GOAL, 5, 12, by_people=True)]
    assert bench.says(8, "w2", sure=True) == (REFUSED.NOT_ADMITTED, "7")
    assert bench.says(7, "w3") == (None, "")
    bench.body.instruct(Admit(GOAL, 20, arrived=5))
    assert bench.arrived == 12, "what is in never falls"


words = st.tuples(st.integers(-1, 9), st.sampled_from("abcdef"), st.booleans(), st.booleans())


@given(st.integers(0, 20), st.lists(words, max_size=30))
def test_what_has_arrived_is_the_sum_of_words_that_were_taken_and_never_more_than_admitted(
    admitted: int, said: list[tuple[int, str, bool, bool]]
) -> None:
    bench = Bench(admitted)
    taken: dict[str, int] = {}
    seen: set[str] = set()
    for pieces, key, sure, dies in said:
        refused, _ = bench.says(pieces, key, sure=sure)
        if refused is None and key not in seen:
            taken[key] = pieces
        seen.add(key)
        if dies:
            bench.begin()
        assert bench.arrived == sum(taken.values()) <= admitted
