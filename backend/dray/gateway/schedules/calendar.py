"""Calendars: recurring moments by a cron expression in a time zone, without holidays. Pure.

Expressions are those of cron in Debian, with its rules for clock changes. A fixed time (`30 2 * * *`) occurs
once each day: if the clock skips it, at the moment of the change; if it occurs twice, at the first. An
expression with `*` in its minutes or hours (`*/30 * * * *`) follows the clock: skipped times do not occur,
repeated times occur twice.
"""

from __future__ import annotations

from collections.abc import Iterator
from datetime import UTC, date, datetime, time
from functools import cache
from itertools import islice
from math import floor
from zoneinfo import ZoneInfo, available_timezones

from cronsim import CronSim, CronSimError

from dray.gateway.http.problems import FieldError
from dray.gateway.schedules import public_holidays

FIELDS = 5
"""Minute, hour, day of the month, month, day of the week."""

LATEST = datetime(2200, 1, 1, tzinfo=UTC)
"""Latest planned moment."""

LATEST_BY_REGION = datetime(2101, 1, 1, tzinfo=UTC)
"""Latest planned moment with public holidays: the library knows none after 2100."""


class Calendar:
    """The moments of recurring work.

    Args:
        expression: a cron expression with five fields.
        time_zone: an IANA name, such as `Europe/Berlin`.
        holidays: days in that time zone that are left out.
        skipped: single moments that are left out.
        holidays_of: a country or region whose public holidays are left out, as `DE-BW`; empty for none.

    Raises:
        CalendarError: the calendar is invalid; it tells what would be right.
    """

    def __init__(
        self,
        expression: str,
        time_zone: str,
        holidays: frozenset[date] = frozenset(),
        skipped: frozenset[float] = frozenset(),
        holidays_of: str = "",
    ) -> None:
        if time_zone not in _time_zones():
            raise CalendarError(FieldError.of("time_zone", "zone_unknown", zone=time_zone))
        self._expression, self._zone = expression, ZoneInfo(time_zone)
        self._holidays, self._skipped, self._holidays_of = holidays, skipped, holidays_of
        if len(expression.split()) != FIELDS:
            raise CalendarError(FieldError.of("calendar", "cron_fields"))
        try:
            CronSim(expression, datetime(2030, 1, 1, tzinfo=self._zone))
        except CronSimError as error:
            reason = str(error)
            why = f"{reason[:1].lower()}{reason[1:]}"
            raise CalendarError(FieldError.of("calendar", "cron_unreadable", why=why)) from None
        if holidays_of and (fault := public_holidays.fault_of(holidays_of)) is not None:
            raise CalendarError(fault)

    def local(self, wall_s: float) -> datetime:
        """A moment in the calendar's time zone."""
        return datetime.fromtimestamp(wall_s, self._zone)

    def after(self, wall_s: float) -> float | None:
        """The first moment after a time, in seconds since 1970; None if there is none."""
        return next(self._moments(wall_s), None)

    def has(self, wall_s: float) -> bool:
        """Whether this is one of its moments."""
        found = next(CronSim(self._expression, self.local(wall_s - 1.0)), None)
        return (
            found is not None
            and found.timestamp() == wall_s
            and not self._is_off(found.date())
            and wall_s not in self._skipped
        )

    def preview(self, wall_s: float, count: int) -> list[float]:
        """The first moments after a time."""
        return list(islice(self._moments(wall_s), count))

    def newest(self, first_s: float, until_s: float) -> float:
        """The last moment in a span that begins with the moment `first_s`; both ends count."""
        # The backward search finds only earlier moments.
        start = self.local(floor(until_s) + 1)
        while True:
            found = next(CronSim(self._expression, start, reverse=True), None)
            if found is None or found.timestamp() <= first_s:
                return first_s
            if self._is_off(found.date()):
                start = datetime.combine(found.date(), time.min, self._zone)
            elif found.timestamp() in self._skipped:
                start = found
            else:
                return found.timestamp()

    def _is_off(self, day: date) -> bool:
        if day in self._holidays:
            return True
        return bool(self._holidays_of) and day in public_holidays.of_year(self._holidays_of, day.year)

    def _moments(self, wall_s: float) -> Iterator[float]:
        start, latest = self.local(wall_s), LATEST_BY_REGION if self._holidays_of else LATEST
        while True:
            for found in CronSim(self._expression, start):
                if found > latest:
                    return
                if self._is_off(found.date()):
                    # Skip the whole day: by minutes it could take a thousand steps.
                    start = datetime.combine(found.date(), time(23, 59, 59), self._zone)
                    break
                if found.timestamp() not in self._skipped:
                    yield found.timestamp()
            else:
                return


class CalendarError(ValueError):
    """An invalid calendar.

    Attributes:
        error: the field, and the reason.
    """

    def __init__(self, error: FieldError) -> None:
        self.error = error
        super().__init__(error.reason)


@cache
def _time_zones() -> frozenset[str]:
    return frozenset(available_timezones())
