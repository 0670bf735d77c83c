"""Gaps in agents' numbered histories."""

from __future__ import annotations

from dray.store.gaps import MISSING_PER_AGENT, Gaps


def test_numbers_in_order_leave_no_gap() -> None:
    gaps = Gaps()
    for number in (1, 2, 2, 3):
        gaps.note("M1", 1, number)
    assert gaps.missing == 0


def test_a_skipped_number_is_missing_until_it_comes() -> None:
    gaps = Gaps()
    gaps.note("M1", 1, 3)
    assert gaps.missing == 2
    gaps.note("M1", 1, 1)
    gaps.note("M1", 1, 1)
    assert gaps.missing == 1


def test_a_new_life_counts_from_one() -> None:
    gaps = Gaps({"M1": (1, 50)})
    gaps.note("M1", 1, 51)
    gaps.note("M1", 2, 1)
    gaps.note("M1", 1, 60)
    assert gaps.missing == 0


def test_numbers_are_remembered_to_a_bound_and_counted_beyond() -> None:
    gaps = Gaps()
    gaps.note("M1", 1, 3 * MISSING_PER_AGENT)
    assert gaps.missing == 3 * MISSING_PER_AGENT - 1
    gaps.note("M1", 1, 1)
    assert gaps.missing == 3 * MISSING_PER_AGENT - 1
    gaps.note("M1", 1, 3 * MISSING_PER_AGENT - 1)
    assert gaps.missing == 3 * MISSING_PER_AGENT - 2
