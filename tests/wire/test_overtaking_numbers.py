"""A number makes lower ones old for 35 s, by any clock and for any number of speakers, and no longer."""

from __future__ import annotations

import pytest

from dray.adapters.security.seals import FRESH_S
from dray.messages.base import CLOCKS_AGREE_S, COUNT_MAX
from dray.messages.overtaken import OVERTAKES_S, LatestNumber, LatestNumbers

HOUR_S = 3600.0


def test_no_message_that_is_played_again_counts_as_a_new_one() -> None:
    """A bus with certificates passes a message on for `FRESH_S`, by another clock."""
    assert OVERTAKES_S > FRESH_S + 2 * CLOCKS_AGREE_S


@pytest.mark.parametrize("gap_s", [0.0, OVERTAKES_S])
def test_within_that_time_only_a_higher_number_counts(gap_s: float) -> None:
    for old in [(1, 7), (1, 6), (0, COUNT_MAX)]:
        assert not LatestNumber((1, 7), 10.0).takes(old, 10.0 + gap_s)
    for later in [(1, 8), (2, 1)]:
        assert LatestNumber((1, 7), 10.0).takes(later, 10.0 + gap_s)


def test_after_that_time_a_lower_number_counts_and_the_next_ones_are_compared_with_it() -> None:
    newest = LatestNumber((COUNT_MAX, COUNT_MAX), 10.0)
    now_s = 10.0 + OVERTAKES_S + 0.1
    assert newest.takes((1, 8), now_s)
    assert not newest.takes((1, 8), now_s + 1.0)
    assert newest.takes((1, 9), now_s + 1.0)


def test_a_clock_that_is_set_back_makes_nobody_old_for_longer() -> None:
    newest = LatestNumber((COUNT_MAX, 1), HOUR_S)
    assert not newest.takes((1, 8), 1.0)
    assert newest.takes((1, 8), 1.0 + OVERTAKES_S + 0.1)


def test_a_statement_that_is_repeated_makes_lower_ones_old_anew() -> None:
    """Of several gateways that speak about one order, the one that knows less changes nothing while the other one speaks."""
    newest = LatestNumber((2,), 0.0)
    for now_s in (15.0, 30.0, 45.0):
        assert newest.stands((2,), now_s)
        assert not newest.stands((1,), now_s)
    assert newest.stands((1,), 45.0 + OVERTAKES_S + 0.1)


def test_each_speaker_has_its_own_number() -> None:
    newest: LatestNumbers[str] = LatestNumbers()
    assert newest.takes("ATV1", (COUNT_MAX,), 0.0)
    assert newest.takes("ATV2", (1,), 1.0)
    assert not newest.takes("ATV1", (1,), 1.0)


def test_whoever_is_heard_least_lately_is_forgotten_first() -> None:
    newest: LatestNumbers[str] = LatestNumbers(kept=2)
    for number, speaker in enumerate(["ATV1", "ATV2", "ATV1", "ATV3"]):
        assert newest.takes(speaker, (number + 1,), 0.0)
    assert not newest.takes("ATV1", (3,), 1.0)
    assert newest.takes("ATV2", (1,), 1.0)


def test_what_stands_since_an_earlier_life_counts_as_heard_when_this_one_began() -> None:
    newest: LatestNumbers[str] = LatestNumbers()
    assert not newest.of("O1", (COUNT_MAX,), 10.0).stands((1,), 10.0)
    assert newest.of("O1", (COUNT_MAX,), 50.0).stands((1,), 50.0)
    assert newest.of("O2", (COUNT_MAX,), 50.0, since_s=0.0).stands((1,), 50.0)
