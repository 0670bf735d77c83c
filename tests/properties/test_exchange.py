"""An exchange: whatever a way loses, doubles or delays, both sides hear everything once and in order."""

from __future__ import annotations

from random import Random

import msgspec
import pytest
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, rule

from dray.adapters.remote_body.exchange import KEPT_MAX, PARTS_PER_LETTER, Exchange, Letter, Part
from dray.errors import ProtocolViolation


def part(number: int) -> Part:
    return "Number", msgspec.Raw(str(number).encode())


class Exchanging(RuleBasedStateMachine):
    """Two sides, and the letters that are under way from each of them; a letter may arrive any number of times."""

    def __init__(self) -> None:
        super().__init__()
        self.sides = Exchange(), Exchange()
        self.said: tuple[list[Part], list[Part]] = ([], [])
        self.heard: tuple[list[Part], list[Part]] = ([], [])
        self.under_way: tuple[list[Letter], list[Letter]] = ([], [])

    @rule(side=st.integers(0, 1), count=st.integers(1, 2 * PARTS_PER_LETTER))
    def say(self, side: int, count: int) -> None:
        for _ in range(min(count, KEPT_MAX - self.sides[side].kept)):
            self.said[side].append(part(len(self.said[side])))
            self.sides[side].say(self.said[side][-1])

    @rule(side=st.integers(0, 1))
    def write(self, side: int) -> None:
        self.under_way[side].append(self.sides[side].write())

    @rule(side=st.integers(0, 1), which=st.randoms(use_true_random=False))
    def arrive(self, side: int, which: Random) -> None:
        if letters := self.under_way[side]:
            self.deliver(side, which.choice(letters))

    def deliver(self, side: int, letter: Letter) -> None:
        self.heard[1 - side].extend(self.sides[1 - side].read(letter))

    @invariant()
    def what_is_heard_was_said_in_this_order(self) -> None:
        for side in (0, 1):
            heard = self.heard[1 - side]
            assert heard == self.said[side][: len(heard)]
            assert self.sides[side].kept >= len(self.said[side]) - len(heard)

    def teardown(self) -> None:
        """From now on letters arrive: then both have heard all, know it, and have nothing more to write."""
        while any(side.due for side in self.sides):
            for side in (0, 1):
                self.deliver(side, self.sides[side].write())
        assert self.heard == (self.said[1], self.said[0])
        assert [side.kept for side in self.sides] == [0, 0]


TestExchanging = Exchanging.TestCase


def test_a_part_counts_as_written_again_until_the_other_side_has_said_that_it_is_heard() -> None:
    here, there = Exchange(), Exchange()
    here.say(part(1))
    here.write()
    assert here.again == 0
    here.say(part(2))
    there.read(here.write())
    assert here.again == 1
    here.read(there.write())
    here.say(part(3))
    here.write()
    assert (here.said, there.heard, here.again) == (3, 2, 1)


def test_a_side_that_keeps_too_much_says_nothing_more_and_has_lost_nothing() -> None:
    side, other = Exchange(), Exchange()
    for number in range(KEPT_MAX):
        assert not side.full
        side.say(part(number))
    assert side.full
    with pytest.raises(ProtocolViolation, match="let go of the other side"):
        side.say(part(KEPT_MAX))
    heard: list[Part] = []
    while side.due:
        heard.extend(other.read(side.write()))
        side.read(other.write())
    assert heard == [part(number) for number in range(KEPT_MAX)]
    assert not side.full
