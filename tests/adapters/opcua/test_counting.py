"""What two looks at a counter say: pieces, a counter that rolled over or was reset, and what cannot be."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dray.adapters.signals.counting import CounterState, count, count_pulse
from dray.adapters.signals.signal import Edge


def pieces(last: int, now: int, *moduli: int, span_s: float = 10.0, gap: bool = False) -> tuple[int, str]:
    reading = count(CounterState(last, 0.0), CounterState(now, span_s), 10.0, moduli, gap=gap)
    return reading.pieces, reading.doubt


@pytest.mark.parametrize(
    ("last", "now", "moduli", "counted"),
    [
        (5, 5, (), 0),
        (5, 6, (), 1),
        (5, 8, (), 3),
        (65_535, 0, (65_536,), 1),
        (65_534, 1, (65_536,), 3),
        (32_767, 0, (32_768, 65_536), 1),
        (32_767, 32_768, (32_768, 65_536), 1),
        (99, 0, (100,), 1),
        (1_234, 0, (), 0),
        (1_234, 2, (), 2),
    ],
)
def test_a_counter_that_can_be_believed(last: int, now: int, moduli: tuple[int, ...], counted: int) -> None:
    assert pieces(last, now, *moduli) == (counted, "")


@pytest.mark.parametrize(
    ("last", "now", "why"),
    [
        (10, 10_010, "went from 10 to 10,010: 4 pieces at most can have been made since"),
        (10_000, 9_000, "went from 10,000 to 9,000: it counts backwards"),
        (10, 9, "went from 10 to 9: it counts backwards"),
    ],
)
def test_a_counter_that_cannot_is_doubted_and_nothing_is_counted(last: int, now: int, why: str) -> None:
    assert pieces(last, now) == (0, why)


def test_after_an_hour_away_an_hours_pieces_are_believed_and_not_more() -> None:
    assert pieces(0, 300, span_s=3_600.0, gap=True) == (300, "")
    assert pieces(0, 600, span_s=3_600.0, gap=True)[0] == 0


def test_a_counter_that_stood_for_an_hour_has_not_made_an_hours_pieces_at_once() -> None:
    assert pieces(0, 300, span_s=3_600.0)[0] == 0


def test_a_reset_that_nobody_heard_is_counted_and_doubted() -> None:
    counted, doubt = pieces(1_234, 2, gap=True)
    assert (counted, "pieces made before that may be missing" in doubt) == (2, True)


@given(st.integers(0, 65_535), st.lists(st.integers(0, 4), max_size=50))
def test_whatever_the_steps_every_piece_is_counted_once_over_the_end(first: int, steps: list[int]) -> None:
    value, total = first, 0
    for step in steps:
        now = (value + step) % 65_536
        counted, doubt = pieces(value, now, 65_536)
        assert not doubt
        total, value = total + counted, now
    assert total == sum(steps)


@given(st.integers(0, 2**40), st.integers(0, 2**40), st.booleans())
def test_no_two_values_give_more_pieces_than_can_have_been_made(last: int, now: int, gap: bool) -> None:
    assert 0 <= pieces(last, now, 65_536, gap=gap)[0] <= 4


def test_a_pulse_counts_at_its_edge_and_not_after_a_gap() -> None:
    assert [
        count_pulse(last, now, Edge.RISING, gap=False).pieces
        for last, now in ((False, True), (True, True), (True, False), (False, False))
    ] == [1, 0, 0, 0]
    assert count_pulse(True, False, Edge.FALLING, gap=False).pieces == 1
    after = count_pulse(False, True, Edge.RISING, gap=True)
    assert (after.pieces, bool(after.doubt)) == (0, True)
