"""Calendars: cron's expressions in a time zone, also in the nights in which clocks are set."""

from __future__ import annotations

from datetime import UTC, date, datetime, timedelta

import pytest

from dray.gateway.schedules.calendar import Calendar, CalendarError

BERLIN = "Europe/Berlin"

NIGHTS = (datetime(2030, 3, 31, tzinfo=UTC), datetime(2030, 10, 27, tzinfo=UTC))
"""In the first clocks go from 02:00 to 03:00, in the second from 03:00 back to 02:00."""


def at(text: str) -> float:
    return datetime.fromisoformat(text).timestamp()


def told(calendar: Calendar, after: str, count: int) -> list[str]:
    return [calendar.local(moment_s).isoformat() for moment_s in calendar.preview(at(after), count)]


def test_the_same_hour_of_the_clock_in_summer_and_in_winter() -> None:
    calendar = Calendar("0 6 * * MON-FRI", BERLIN)
    assert told(calendar, "2030-10-25T12:00:00Z", 2) == [
        "2030-10-28T06:00:00+01:00",
        "2030-10-29T06:00:00+01:00",
    ]
    assert told(calendar, "2030-03-29T04:59:00Z", 2) == [
        "2030-03-29T06:00:00+01:00",
        "2030-04-01T06:00:00+02:00",
    ]


def test_a_fixed_time_that_does_not_exist_comes_when_the_clock_goes_on() -> None:
    assert told(Calendar("30 2 * * *", BERLIN), "2030-03-30T12:00:00Z", 2) == [
        "2030-03-31T03:00:00+02:00",
        "2030-04-01T02:30:00+02:00",
    ]


def test_a_fixed_time_that_exists_twice_comes_once() -> None:
    assert told(Calendar("30 2 * * *", BERLIN), "2030-10-26T12:00:00Z", 2) == [
        "2030-10-27T02:30:00+02:00",
        "2030-10-28T02:30:00+01:00",
    ]


def test_with_a_star_it_goes_by_the_clock_as_it_runs() -> None:
    hourly = Calendar("30 * * * *", BERLIN)
    assert told(hourly, "2030-03-31T00:00:00Z", 2) == [
        "2030-03-31T01:30:00+01:00",
        "2030-03-31T03:30:00+02:00",
    ]
    assert told(hourly, "2030-10-27T00:00:00Z", 3) == [
        "2030-10-27T02:30:00+02:00",
        "2030-10-27T02:30:00+01:00",
        "2030-10-27T03:30:00+01:00",
    ]
    in_the_gap = Calendar("*/30 2 * * *", BERLIN)
    assert told(in_the_gap, "2030-03-30T12:00:00Z", 1) == ["2030-04-01T02:00:00+02:00"]


def test_on_holidays_of_its_own_zone_nothing_comes() -> None:
    calendar = Calendar("30 23 * * *", BERLIN, frozenset({date(2030, 12, 25)}))
    assert told(calendar, "2030-12-24T12:00:00Z", 2) == [
        "2030-12-24T23:30:00+01:00",
        "2030-12-26T23:30:00+01:00",
    ]


def test_a_year_of_holidays_is_passed_over() -> None:
    days = frozenset(date(2030, 1, 1) + timedelta(days=day) for day in range(365))
    calendar = Calendar("* * * * *", BERLIN, days)
    assert told(calendar, "2030-01-01T00:00:00Z", 1) == ["2031-01-01T00:00:00+01:00"]


@pytest.mark.parametrize("night", NIGHTS)
@pytest.mark.parametrize(
    "expression",
    ["30 2 * * *", "*/20 * * * *", "*/20 2 * * *", "0,30 2 * * *", "15 1,2,3 * * *", "0 5 * * *"],
)
def test_the_newest_is_the_last_of_those_that_come(expression: str, night: datetime) -> None:
    holiday = (night + timedelta(days=1)).date()
    calendar = Calendar(expression, BERLIN, frozenset({holiday}))
    until_s = night.timestamp() + 4 * 86_400
    moments = [each for each in calendar.preview(night.timestamp() - 2 * 86_400, 500) if each <= until_s]
    assert len(moments) > 3
    for moment_s in (*moments, until_s):
        for asked_s in (moment_s, moment_s + 0.5, moment_s + 59.5, max(moments[0], moment_s - 0.5)):
            assert calendar.newest(moments[0], asked_s) == max(each for each in moments if each <= asked_s)


@pytest.mark.parametrize(
    ("expression", "zone", "field", "reason"),
    [
        ("0 6 * *", BERLIN, "calendar", "give five fields"),
        ("0 6 * * * *", BERLIN, "calendar", "give five fields"),
        ("@daily", BERLIN, "calendar", "give five fields"),
        ("60 6 * * *", BERLIN, "calendar", "bad minute"),
        ("0 0 30 2 *", BERLIN, "calendar", "bad day-of-month"),
        ("0 6 * * *", "Europe/Bärlin", "time_zone", "there is no time zone"),
        ("0 6 * * *", "../../etc/passwd", "time_zone", "there is no time zone"),
    ],
)
def test_what_is_no_calendar_is_refused_with_what_would_be(
    expression: str, zone: str, field: str, reason: str
) -> None:
    with pytest.raises(CalendarError, match=reason) as refused:
        Calendar(expression, zone)
    assert refused.value.error.field == field
