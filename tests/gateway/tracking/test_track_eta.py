"""When an order will be there: honest ranges, and none where nobody can know."""

from __future__ import annotations

import random

import msgspec
import pytest

from dray.gateway.live.timescale import TimeScale, WallWorkingTime
from dray.gateway.tracking.eta import PROMISES_NEEDED, History, Range, Running, eta, quantile, rounded
from dray.plant.working_time import WeeklySpan, WorkingHours, WorkingTime

NOW_S = 1000.0
WAY_S = (60.0, 180.0)


def paced(made: int, quantity: int, gap_s: float = 10.0, until_s: float = NOW_S) -> Running:
    times = tuple(until_s - gap_s * (made - 1 - number) for number in range(made))
    return Running(quantity, made, promised_at_s=None, piece_times_s=times)


def test_a_steady_pace_is_carried_on_and_the_way_is_added() -> None:
    found = eta([paced(10, 20)], History(way_s=WAY_S), NOW_S)
    assert found == Range(NOW_S + 100 + 60, NOW_S + 100 + 180)


STEPS = (10, 30, 60, 90)
"""Pieces made of 100 when somebody asks."""


def asked_on_the_way(seed: int) -> list[tuple[float, bool]]:
    """An uneven goal of 100 pieces: at each step how wide the range was, and whether the end came in it."""
    chance = random.Random(seed)
    times = [0.0]
    for _ in range(99):
        times.append(times[-1] + chance.uniform(5, 15))
    asked = []
    for made in STEPS:
        goal = Running(100, made, piece_times_s=tuple(times[:made]))
        found = eta([goal], History(way_s=(0.0, 0.0)), times[made - 1])
        assert found is not None
        asked.append((found.to_s - found.from_s, found.from_s <= times[-1] <= found.to_s))
    return asked


def test_the_range_tightens_as_pieces_are_made_and_nine_of_ten_ends_come_within_it() -> None:
    runs = [asked_on_the_way(seed) for seed in range(200)]
    for step in range(len(STEPS)):
        assert sum(run[step][1] for run in runs) >= 0.9 * len(runs)
    widths_s = [sum(run[step][0] for run in runs) for step in range(len(STEPS))]
    assert widths_s == sorted(widths_s, reverse=True)


def test_an_uneven_pace_makes_a_wider_range_than_a_steady_one() -> None:
    even = eta([paced(9, 20)], History(way_s=WAY_S), NOW_S)
    uneven = Running(20, 9, piece_times_s=(920, 921, 940, 941, 960, 961, 980, 981, 1000))
    found = eta([uneven], History(way_s=WAY_S), NOW_S)
    assert even is not None
    assert found is not None
    assert found.to_s - found.from_s > even.to_s - even.from_s


def test_a_halt_moves_the_range_and_makes_it_wider() -> None:
    before = eta([paced(10, 20)], History(way_s=WAY_S), NOW_S)
    after = eta([paced(10, 20)], History(way_s=WAY_S), NOW_S + 300)
    assert before is not None
    assert after is not None
    assert after.from_s > before.from_s + 200
    assert after.to_s - after.from_s > before.to_s - before.from_s + 200


def test_what_is_all_made_has_only_its_way_before_it() -> None:
    assert eta([paced(20, 20)], History(way_s=WAY_S), NOW_S) == Range(NOW_S + 60, NOW_S + 180)


def test_a_promise_that_more_urgent_goals_have_overtaken_counts_no_more() -> None:
    missed_by_s = tuple(float(number) for number in range(-2, 8))
    late = Running(20, 2, promised_at_s=2000.0, ahead_s=1500.0)
    assert eta([late], History(missed_by_s, WAY_S), NOW_S) == Range(NOW_S + 1500.0 - 2, NOW_S + 1500.0 + 6)
    early = msgspec.structs.replace(late, ahead_s=900.0)
    assert eta([early], History(missed_by_s, WAY_S), NOW_S) == Range(2000.0 - 2, 2000.0 + 6)


def test_a_moved_promise_is_not_moved_once_more_by_what_first_promises_were_missed_by() -> None:
    missed_by_s = tuple(100.0 * number for number in range(10))
    goal = Running(20, 2, promised_at_s=2000.0, is_moved=True)
    assert eta([goal], History(missed_by_s, WAY_S), NOW_S) == Range(2000.0, 2500.0)


def test_before_there_is_a_pace_a_promise_counts_as_far_as_promises_have_been_kept() -> None:
    missed_by_s = tuple(float(number) for number in range(-2, 8))
    found = eta([Running(20, 2, promised_at_s=2000.0)], History(missed_by_s, WAY_S), NOW_S)
    assert found == Range(2000.0 - 2, 2000.0 + 6)


@pytest.mark.parametrize("known", range(PROMISES_NEEDED))
def test_a_promise_of_which_nothing_is_known_is_given_half_its_time_more(known: int) -> None:
    found = eta([Running(20, 0, promised_at_s=2000.0)], History((5.0,) * known, WAY_S), NOW_S)
    assert found == Range(2000.0, 2500.0)


def test_an_order_comes_with_the_last_of_its_goals() -> None:
    found = eta([paced(10, 12), paced(10, 20)], History(way_s=WAY_S), NOW_S)
    assert found == eta([paced(10, 20)], History(way_s=WAY_S), NOW_S)


def test_one_goal_of_which_nothing_is_known_leaves_nothing_to_say() -> None:
    assert eta([paced(10, 20), Running(5, 0)], History(way_s=WAY_S), NOW_S) is None
    assert eta([], History(way_s=WAY_S), NOW_S) is None


def test_nothing_is_expected_in_the_past_and_what_is_overdue_is_expected_ever_less_exactly() -> None:
    goal = Running(20, 0, promised_at_s=900.0)
    found = [eta([goal], History(way_s=WAY_S), now_s) for now_s in (1000.0, 1500.0)]
    assert found == [Range(1000.0, 1100.0), Range(1500.0, 2100.0)]


@pytest.mark.parametrize(
    ("exact", "shown"),
    [
        ((61.0, 100.0), (60.0, 120.0)),
        ((60.0, 60.0), (60.0, 60.0)),
        ((1000.0, 2000.0), (900.0, 2100.0)),
        ((1000.0, 20_000.0), (900.0, 20_700.0)),
    ],
)
def test_the_clock_is_read_as_exactly_as_the_range_allows_and_outwards(
    exact: tuple[float, float], shown: tuple[float, float]
) -> None:
    assert rounded(Range(*exact)) == Range(*shown)


def test_a_quantile_is_a_value_that_really_was() -> None:
    values = [1.0, 2.0, 3.0, 4.0, 100.0]
    assert [quantile(values, part) for part in (0.0, 0.1, 0.5, 0.9, 1.0)] == [1.0, 1.0, 3.0, 100.0, 100.0]


HOUR_S = 3600.0
MORNINGS = WorkingTime(WorkingHours(shifts=(WeeklySpan("06:00", "12:00"),)))


def test_a_pace_goes_on_in_working_time_alone() -> None:
    """Ten pieces by noon, one in ten minutes; the next ten are made in the morning after."""
    made = paced(10, 20, gap_s=600.0, until_s=12 * HOUR_S)
    goal = msgspec.structs.replace(made, working=MORNINGS)
    for now_s in (12 * HOUR_S, 20 * HOUR_S, 30 * HOUR_S):
        assert eta([goal], History(way_s=WAY_S), now_s) == Range(
            30 * HOUR_S + 6000.0 + 60.0, 30 * HOUR_S + 6000.0 + 180.0
        )


def test_a_night_between_two_pieces_is_no_slow_piece() -> None:
    times = (*(11 * HOUR_S + 600.0 * number for number in range(6)), 30 * HOUR_S, 30 * HOUR_S + 600.0)
    goal = Running(10, 8, piece_times_s=times, working=MORNINGS)
    found = eta([goal], History(way_s=(0.0, 0.0)), times[-1])
    assert found is not None
    assert found.to_s < times[-1] + HOUR_S


def test_who_never_works_again_cannot_say() -> None:
    never = WorkingTime(
        WorkingHours(shifts=(WeeklySpan("06:00", "07:00"),), breaks=(WeeklySpan("00:00", "00:00"),))
    )
    goal = msgspec.structs.replace(paced(10, 20), working=never)
    assert eta([goal], History(way_s=WAY_S), NOW_S) is None


def test_a_working_time_on_the_wall_is_that_of_the_plant_at_its_speed() -> None:
    wall = WallWorkingTime(MORNINGS, TimeScale(plant_epoch_s=0.0, wall_epoch_s=1e6, speed=10.0))
    assert wall.after_s(1e6, 60.0) == 1e6 + (6 * HOUR_S + 600.0) / 10.0
    assert wall.between_s(1e6, 1e6 + 9 * HOUR_S / 10.0) == 3 * HOUR_S / 10.0
    assert wall.between_s(1e6 + 9 * HOUR_S / 10.0, 1e6) == -3 * HOUR_S / 10.0
