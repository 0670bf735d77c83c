"""Days, times and numbers, in one language and one time zone."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta, tzinfo
from zoneinfo import ZoneInfo

from dray.gateway.tracking.eta import Range
from dray.gateway.tracking.texts.catalogue import Catalogue

ZONE_CHARS = 64
"""Maximum characters of a time zone's name; the longest has about 32."""


def zone_named(name: str) -> tzinfo | None:
    """The time zone of this name; None if it is unknown or invalid."""
    if not name or len(name) > ZONE_CHARS:
        return None
    try:
        return ZoneInfo(name)
    except (KeyError, OSError, ValueError):
        # Unknown here, or a path to another file.
        return None


class Clock:
    """Writes times for people.

    Args:
        texts: the language.
        zone: the reader's time zone; None for this computer's.
        now_s: wall clock.
    """

    def __init__(self, texts: Catalogue, zone: tzinfo | None, now_s: float) -> None:
        self._texts, self._zone = texts, zone
        self._today = self._local(now_s).date()

    @property
    def zone(self) -> str:
        """The zone's usual name, as Europe/Madrid or CET."""
        return self._zone.key if isinstance(self._zone, ZoneInfo) else (self._local(0).tzname() or "UTC")

    def time(self, at_s: float) -> str:
        """13:10."""
        return f"{self._local(at_s):%H:%M}"

    def day(self, at_s: float) -> str:
        """today, Fri 20 Nov, or 20 Nov 2031 in another year; as within a sentence."""
        calendar, date = self._texts.calendar, self._local(at_s).date()
        near = {-1: calendar.yesterday, 0: calendar.today, 1: calendar.tomorrow}
        days = (date - self._today) // timedelta(days=1)
        if days in near:
            return near[days]
        form = calendar.day if date.year == self._today.year else calendar.day_of_year
        return form.format(
            weekday=calendar.weekdays[date.weekday()],
            day=date.day,
            month=calendar.months[date.month - 1],
            year=date.year,
        )

    def full(self, at_s: float) -> str:
        """17 Mar 2030, 13:10: also correct on paper, on another day."""
        calendar, date = self._texts.calendar, self._local(at_s).date()
        month = calendar.months[date.month - 1]
        return f"{calendar.day_of_year.format(day=date.day, month=month, year=date.year)}, {self.time(at_s)}"

    def moment(self, at_s: float) -> str:
        """Today, 13:10: standing alone."""
        return _begun(self.inside(at_s))

    def inside(self, at_s: float) -> str:
        """today, 13:10: within a sentence."""
        return f"{self.day(at_s)}, {self.time(at_s)}"

    def range(self, between: Range, now_s: float) -> str:
        """Today, 13:10 – 13:50; once the range has begun, only its end."""
        first, last = self.day(between.from_s), self.day(between.to_s)
        if between.from_s <= now_s:
            return _begun(self._texts.by_about.format(day=last, to=self.time(between.to_s)))
        if first == last:
            words = {"from": self.time(between.from_s), "to": self.time(between.to_s)}
            return _begun(self._texts.range.format(day=first, **words))
        return f"{self.moment(between.from_s)} – {self.inside(between.to_s)}"

    def number(self, value: int) -> str:
        """1,250."""
        calendar = self._texts.calendar
        if value < calendar.thousands_from:
            return str(value)
        return f"{value:,}".replace(",", calendar.thousands)

    @staticmethod
    def iso(at_s: float) -> str:
        """The time in ISO 8601, in UTC."""
        return datetime.fromtimestamp(at_s, UTC).isoformat(timespec="seconds").replace("+00:00", "Z")

    def date(self) -> str:
        """The reader's date in ISO 8601."""
        return self._today.isoformat()

    def _local(self, at_s: float) -> datetime:
        return datetime.fromtimestamp(at_s, UTC).astimezone(self._zone)


def _begun(text: str) -> str:
    """The text with a capital first letter, and no other change."""
    return text[:1].upper() + text[1:]
