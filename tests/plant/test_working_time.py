"""Working time: shifts of the week in local time, without breaks and holidays; every answer is one of minute by minute."""

from __future__ import annotations

from datetime import datetime
from zoneinfo import ZoneInfo

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from dray.plant.working_time import DAYS, WeeklySpan, WorkingHours, WorkingTime

BERLIN = ZoneInfo("Europe/Berlin")
OFFICE = WorkingHours(
    shifts=(WeeklySpan("06:00", "14:00", ("mon", "tue", "wed", "thu", "fri")),),
    breaks=(WeeklySpan("09:00", "09:30"),),
    holidays=("2026-12-25",),
)


def at(text: str, zone: ZoneInfo = BERLIN) -> float:
    return datetime.fromisoformat(text).replace(tzinfo=zone).timestamp()


def berlin(hours: WorkingHours) -> WorkingTime:
    return WorkingTime(hours, "Europe/Berlin")


def test_without_hours_it_is_always_working_time() -> None:
    always = WorkingTime(None)
    assert always.is_always
    assert always.is_on(5.0)
    assert always.next_change_s(5.0) == float("inf")
    assert (always.after_s(5.0, 10.0), always.before_s(5.0, 10.0)) == (15.0, -5.0)
    assert (always.between_s(5.0, 25.0), always.between_s(25.0, 5.0)) == (20.0, -20.0)


@pytest.mark.parametrize(
    ("now", "is_on", "next_on", "next_change"),
    [
        ("2026-11-26 05:59", False, "2026-11-26 06:00", "2026-11-26 06:00"),
        ("2026-11-26 06:00", True, "2026-11-26 06:00", "2026-11-26 09:00"),
        ("2026-11-26 09:00", False, "2026-11-26 09:30", "2026-11-26 09:30"),
        ("2026-11-26 13:59", True, "2026-11-26 13:59", "2026-11-26 14:00"),
        ("2026-11-26 14:00", False, "2026-11-27 06:00", "2026-11-27 06:00"),
        ("2026-11-27 20:00", False, "2026-11-30 06:00", "2026-11-30 06:00"),
        ("2026-12-24 20:00", False, "2026-12-28 06:00", "2026-12-28 06:00"),
    ],
)
def test_a_shift_a_break_a_weekend_and_a_holiday(
    now: str, is_on: bool, next_on: str, next_change: str
) -> None:
    office = berlin(OFFICE)
    assert office.is_on(at(now)) is is_on
    assert office.next_on_s(at(now)) == at(next_on)
    assert office.next_change_s(at(now)) == at(next_change)


def test_work_is_reckoned_over_breaks_nights_and_weekends() -> None:
    office = berlin(OFFICE)
    friday = at("2026-11-27 08:00")
    # One hour until the break, four and a half after it, and half an hour on Monday.
    assert office.after_s(friday, 6 * 3600.0) == at("2026-11-30 06:30")
    assert office.before_s(at("2026-11-30 06:30"), 6 * 3600.0) == friday
    assert office.between_s(friday, at("2026-11-30 06:30")) == 6 * 3600.0
    assert office.between_s(at("2026-11-30 06:30"), friday) == -6 * 3600.0


def test_a_night_shift_belongs_to_the_day_on_which_it_begins() -> None:
    nights = berlin(
        WorkingHours(
            shifts=(WeeklySpan("22:00", "06:00", ("sun", "mon")),), breaks=(WeeklySpan("02:00", "02:30"),)
        )
    )
    assert nights.is_on(at("2026-11-30 05:59"))
    assert not nights.is_on(at("2026-11-30 02:15"))
    assert nights.is_on(at("2026-12-01 05:59"))
    assert not nights.is_on(at("2026-12-02 05:59"))


def test_shifts_that_meet_are_one() -> None:
    rounds = berlin(
        WorkingHours(
            shifts=(
                WeeklySpan("06:00", "14:00"),
                WeeklySpan("14:00", "22:00"),
                WeeklySpan("22:00", "06:00", DAYS[:4]),
            )
        )
    )
    assert rounds.next_change_s(at("2026-11-23 08:00")) == at("2026-11-27 22:00")


def test_what_never_rests_by_its_shifts_is_on_at_once() -> None:
    rounds = berlin(WorkingHours(shifts=(WeeklySpan("00:00", "00:00"),)))
    now_s = at("2026-11-26 12:00")
    assert rounds.is_on(now_s)
    assert rounds.after_s(now_s, 40 * 86_400.0) == now_s + 40 * 86_400.0
    assert rounds.before_s(now_s, 40 * 86_400.0) == now_s - 40 * 86_400.0


def test_clocks_are_put_forward_and_back() -> None:
    nights = berlin(WorkingHours(shifts=(WeeklySpan("22:00", "06:00"),)))
    spring, autumn = at("2026-03-28 22:00"), at("2026-10-24 22:00")
    assert nights.between_s(spring, spring + 12 * 3600.0) == 7 * 3600.0
    assert nights.between_s(autumn, autumn + 12 * 3600.0) == 9 * 3600.0
    # What the clocks leave out is as late as if they did not.
    missing = berlin(WorkingHours(shifts=(WeeklySpan("02:30", "05:00"),)))
    assert missing.next_on_s(at("2026-03-29 00:00")) == at("2026-03-29 03:30")


def test_who_never_works_is_never_on() -> None:
    never = berlin(
        WorkingHours(shifts=(WeeklySpan("08:00", "09:00"),), breaks=(WeeklySpan("00:00", "00:00"),))
    )
    assert never.next_on_s(0.0) == float("inf")
    assert never.next_change_s(0.0) == float("inf")
    assert never.after_s(0.0, 1.0) == float("inf")
    assert never.before_s(0.0, 1.0) == -1.0
    assert never.between_s(0.0, 1e6) == 0.0


TIMES = st.builds("{:02d}:{:02d}".format, st.integers(0, 23), st.sampled_from([0, 15, 30, 45]))
SPANS = st.builds(
    WeeklySpan, TIMES, TIMES, st.lists(st.sampled_from(DAYS), min_size=1, max_size=7, unique=True).map(tuple)
)
HOURS = st.builds(
    WorkingHours,
    shifts=st.lists(SPANS, min_size=1, max_size=4).map(tuple),
    breaks=st.lists(SPANS, max_size=3).map(tuple),
    holidays=st.lists(st.sampled_from(["2026-03-29", "2026-03-31", "2026-10-25"]), max_size=2).map(tuple),
)
QUARTER_S = 900.0


@example(
    WorkingHours(shifts=(WeeklySpan("01:00", "01:00", ("mon",)), WeeklySpan("00:00", "00:00"))),
    "2026-03-26",
    477,
)
@example(
    WorkingHours(shifts=(WeeklySpan("01:00", "00:30", ("wed",)), WeeklySpan("00:00", "00:15", ("thu",)))),
    "2026-03-26",
    2,
)
@given(HOURS, st.sampled_from(["2026-03-26", "2026-06-01", "2026-10-22"]), st.integers(0, 700))
def test_every_answer_is_that_of_quarter_by_quarter(hours: WorkingHours, day: str, quarters: int) -> None:
    time, start_s = berlin(hours), at(day)
    on = [time.is_on(start_s + number * QUARTER_S) for number in range(quarters)]
    worked_s = QUARTER_S * sum(on)
    assert time.between_s(start_s, start_s + quarters * QUARTER_S) == worked_s
    if worked_s:
        last_s = start_s + (max(number for number, works in enumerate(on) if works) + 1) * QUARTER_S
        assert time.after_s(start_s, worked_s) == last_s
        first_s = start_s + on.index(True) * QUARTER_S
        assert time.before_s(start_s + quarters * QUARTER_S, worked_s) == first_s
    changes = [
        start_s + number * QUARTER_S for number in range(1, quarters) if on[number] is not on[number - 1]
    ]
    if changes and changes[0] - start_s < 7 * 86_400.0:
        assert time.next_change_s(start_s) == changes[0]
