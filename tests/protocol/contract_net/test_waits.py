"""What an agent learns of waits at places, and what others can make of it (`waits`)."""

from __future__ import annotations

from math import inf, nan

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dray.messages import Wait
from dray.protocol.contract_net.waits import HALF_LIFE_S, WAIT_MAX_S, Waits
from dray.protocol.runtime.durations import KEPT, SUBJECTS_MAX


def test_of_a_place_that_nobody_has_seen_nothing_is_expected() -> None:
    assert Waits().expect_s("S1", 100.0) == 0.0
    assert Waits().told(("S1", "S2"), 100.0) == ()


def test_what_most_have_waited_is_expected() -> None:
    waits = Waits()
    for number in range(10):
        waits.note("S1", f"ATV{number}", 10.0 * number, 100.0)
    # With one wait of nothing there are eleven, and nine of them are 70 s or less.
    assert waits.expect_s("S1", 100.0) == 70.0
    assert waits.expect_s("S2", 100.0) == 0.0


def test_a_rush_that_is_over_is_forgotten() -> None:
    waits = Waits()
    waits.note("S1", "", 120.0, 0.0)
    assert waits.expect_s("S1", 1.0) == 120.0
    assert waits.expect_s("S1", 3.0 * HALF_LIFE_S) == 0.0


def test_who_comes_through_without_waiting_makes_the_others_hope() -> None:
    waits = Waits()
    waits.note("S1", "", 120.0, 0.0)
    for number in range(1, 5):
        waits.note("S1", "", 0.0, 60.0 * number)
    assert waits.expect_s("S1", 300.0) == 0.0


@settings(deadline=None)  # A slow machine is no failure.
@given(lies=st.lists(st.floats(allow_nan=True, allow_infinity=True), max_size=200))
def test_one_liar_moves_nothing_that_three_others_have_seen(lies: list[float]) -> None:
    waits = Waits()
    for number, seen_s in enumerate((20.0, 30.0, 40.0)):
        waits.note("S1", f"ATV{number}", seen_s, 0.0)
    for lie_s in lies:
        waits.note("S1", "liar", lie_s, 0.0)
    assert 30.0 <= waits.expect_s("S1", 0.0) <= 40.0


@pytest.mark.parametrize(("said_s", "kept_s"), [(-5.0, 0.0), (1e12, WAIT_MAX_S), (7.0, 7.0)])
def test_what_cannot_be_counts_as_the_nearest_that_can(said_s: float, kept_s: float) -> None:
    waits = Waits()
    waits.note("S1", "ATV1", said_s, 0.0)
    assert waits.expect_s("S1", 0.0) == kept_s
    assert waits.told(("S1",), 0.0) == (Wait(place="S1", wait_s=kept_s),)


@pytest.mark.parametrize("said_s", [nan, inf, -inf])
def test_what_is_no_number_counts_for_nothing(said_s: float) -> None:
    waits = Waits()
    waits.note("S1", "ATV1", said_s, 0.0)
    assert waits.told(("S1",), 0.0) == ()


def test_it_is_bounded_however_many_places_and_witnesses_are_made_up() -> None:
    waits = Waits()
    for number in range(10 * SUBJECTS_MAX):
        waits.note(f"S{number}", "liar", 5.0, 0.0)
    for number in range(10 * KEPT):
        waits.note("S0", f"ATV{number}", 5.0, 0.0)
    places = [f"S{number}" for number in range(10 * SUBJECTS_MAX)]
    assert len(waits.told(places, 0.0)) <= SUBJECTS_MAX
    assert waits.expect_s("S0", 0.0) == 5.0
