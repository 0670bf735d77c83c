"""Calendars: cron's expressions in a time zone, also in the nights in which clocks are set."""

from __future__ import annotations

import subprocess
import sys
from datetime import UTC, date, datetime, time, timedelta
from pathlib import Path
from zoneinfo import ZoneInfo

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


OFF_IN_DE = ["01-01", "04-19", "04-22", "05-01", "05-30", "06-10", "10-03", "12-25", "12-26"]
"""Public holidays of all of Germany in 2030."""


@pytest.mark.parametrize(
    ("region", "off"),
    [
        ("DE", [f"2030-{day}" for day in OFF_IN_DE]),
        ("DE-BW", [f"2030-{day}" for day in sorted([*OFF_IN_DE, "01-06", "06-20", "11-01"])]),
    ],
)
def test_on_the_public_holidays_of_its_region_nothing_comes(region: str, off: list[str]) -> None:
    assert days_off("0 6 * * *", region, 2030) == off


def test_movable_holidays_move_with_the_year() -> None:
    easter = {year: days_off("0 6 * 4 *", "DE", year) for year in (2030, 2031)}
    assert easter == {2030: ["2030-04-19", "2030-04-22"], 2031: ["2031-04-11", "2031-04-14"]}


def days_off(expression: str, region: str, year: int) -> list[str]:
    """The days of a year on which a region takes runs out of a calendar."""
    everything, kept = (
        {run.date().isoformat() for run in year_of(expression, BERLIN, of, year)} for of in ("", region)
    )
    return sorted(everything - kept)


def test_a_region_is_one_more_reason_beside_dates_and_single_moments() -> None:
    skipped = frozenset({at("2030-12-27T06:00:00+01:00")})
    calendar = Calendar("0 6 * * *", BERLIN, frozenset({date(2030, 12, 24)}), skipped, "DE")
    before, after = "2030-12-23T06:00:00+01:00", "2030-12-28T06:00:00+01:00"
    assert told(calendar, "2030-12-23T00:00:00Z", 2) == [before, after]
    assert calendar.newest(at(before), at("2030-12-27T12:00:00Z")) == at(before)
    christmas = "2030-12-25T06:00:00+01:00"
    assert [calendar.has(at(each)) for each in (before, christmas, after)] == [True, False, True]


def test_a_public_holiday_is_a_day_of_the_calendars_zone() -> None:
    calendar = Calendar("0 6 * * *", "Pacific/Auckland", holidays_of="DE")
    assert told(calendar, "2030-12-24T00:00:00Z", 2) == [
        "2030-12-27T06:00:00+13:00",
        "2030-12-28T06:00:00+13:00",
    ]


def test_the_library_is_loaded_by_the_first_calendar_with_a_region() -> None:
    code = """
import sys
import dray.gateway.routes.orders.schedules
from dray.gateway.schedules.calendar import Calendar
Calendar("0 6 * * *", "Europe/Berlin").after(0.0)
assert "holidays" not in sys.modules
Calendar("0 6 * * *", "Europe/Berlin", holidays_of="DE").after(0.0)
assert "holidays" in sys.modules
"""
    subprocess.run([sys.executable, "-c", code], check=True)


@pytest.mark.parametrize(
    ("region", "code", "possible"),
    [
        ("XX", "country_unknown", "DE-BW"),
        ("de", "country_unknown", "DE-BW"),
        ("Germany", "country_unknown", "DE-BW"),
        ("DE-XX", "region_unknown", "BW (Baden-Württemberg)"),
        ("DE-", "region_unknown", "BW (Baden-Württemberg)"),
        ("VA-XX", "region_none", "VA alone"),
    ],
)
def test_a_region_without_holidays_is_refused_with_those_that_have_some(
    region: str, code: str, possible: str
) -> None:
    with pytest.raises(CalendarError) as refused:
        Calendar("0 6 * * *", BERLIN, holidays_of=region)
    error = refused.value.error
    assert (error.field, error.code) == ("holidays_of", code)
    assert possible in error.reason


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


DOCUMENT = Path(__file__).parents[3] / "docs/api.md"

EXPRESSIONS = ("30 2 * * *", "0 * * * *", "0 6 * * MON-FRI")

LATE = {
    BERLIN: "2030-03-31T03:00:00+02:00",
    "America/New_York": "2030-03-10T03:00:00-04:00",
    "Australia/Lord_Howe": None,
}
"""When the run of 02:30 comes in the night that lacks that time. On Lord Howe clocks go from 02:00 to 02:30, and back from 02:00 to 01:30."""


def year_of(expression: str, zone: str, region: str = "", year: int = 2030) -> list[datetime]:
    """All runs of a year, asked for one after another as the scheduler does."""
    calendar = Calendar(expression, zone, holidays_of=region)
    now_s, end_s = (datetime(each, 1, 1, tzinfo=ZoneInfo(zone)).timestamp() for each in (year, year + 1))
    found = []
    moment_s = calendar.after(now_s - 1)
    while moment_s is not None and moment_s < end_s:
        found.append(calendar.local(moment_s))
        moment_s = calendar.after(moment_s)
    return found


@pytest.mark.parametrize("zone", LATE)
def test_at_half_past_two_it_comes_once_each_day_of_a_year(zone: str) -> None:
    runs = year_of("30 2 * * *", zone)
    assert [run.date() for run in runs] == [date(2030, 1, 1) + timedelta(days=day) for day in range(365)]
    late = LATE[zone]
    assert [run.isoformat() for run in runs if run.time() != time(2, 30)] == ([late] if late else [])


@pytest.mark.parametrize("zone", LATE)
def test_each_full_hour_of_a_year_comes_once(zone: str) -> None:
    first, last = (datetime(year, 1, 1, tzinfo=ZoneInfo(zone)).timestamp() for year in (2030, 2031))
    # Clocks are set by full or half hours: no full hour is missed by these steps.
    steps = (datetime.fromtimestamp(each, ZoneInfo(zone)) for each in range(int(first), int(last), 1800))
    assert year_of("0 * * * *", zone) == [each for each in steps if each.minute == 0]


@pytest.mark.parametrize("zone", LATE)
def test_at_six_it_comes_once_each_weekday_of_a_year(zone: str) -> None:
    days = (date(2030, 1, 1) + timedelta(days=day) for day in range(365))
    runs = year_of("0 6 * * MON-FRI", zone)
    assert [run.date() for run in runs] == [day for day in days if day.weekday() < 5]
    assert {run.time() for run in runs} == {time(6)}
    assert len({run.utcoffset() for run in runs}) == 2, "in summer and in winter"


@pytest.mark.parametrize("zone", LATE)
def test_the_documents_table_counts_them(zone: str) -> None:
    lines = DOCUMENT.read_text(encoding="utf-8").splitlines()
    [row] = [line.strip("| ").split(" | ") for line in lines if line.startswith(f"| {zone} |")]
    told = [int(row[column].split(":")[0].replace(",", "")) for column in (1, 3, 4)]
    assert told == [len(year_of(each, zone)) for each in EXPRESSIONS]
