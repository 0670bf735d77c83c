"""The working time of a plant, a machine, or an area's people: weekly shifts in local time, less breaks and holidays.

In service the plant's clock is unix time, and so are the times of a calendar. A simulation begins at 0: on a
Thursday, at midnight of UTC. Everything is a lookup: all users of one plant file get the same answers.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from datetime import UTC, date, datetime, timedelta
from functools import cached_property
from typing import Annotated, Literal
from zoneinfo import ZoneInfo

import msgspec
from msgspec import Meta

Day = Literal["mon", "tue", "wed", "thu", "fri", "sat", "sun"]

DAYS: tuple[Day, ...] = ("mon", "tue", "wed", "thu", "fri", "sat", "sun")

DAY_S = 86_400.0
WEEK_S = 7 * DAY_S

TimeOfDay = Annotated[str, Meta(pattern="^([01][0-9]|2[0-3]):[0-5][0-9]$")]
"""Time of a clock on the wall, as ``06:00``."""

IsoDate = Annotated[str, Meta(pattern="^[0-9]{4}-[0-9]{2}-[0-9]{2}$")]
"""A date, as ``2026-12-25``."""

JOINED_MAX_S = 8 * DAY_S
"""Longest piece of working time without a break, so that a calendar that is always on is found at once."""

DAYS_MAX = 3660
"""Most days of a search ahead or back for working time: ten years. Working time beyond that counts as never."""

Span = tuple[float, float]
"""Start and end, in seconds of the plant's clock; the end does not belong to it."""


class WeeklySpan(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A part of some days of every week, in local time."""

    start: TimeOfDay
    end: TimeOfDay
    """First time that does not belong to it. If it is not after `start`, it is a time of the next day: a night shift."""
    days: Annotated[tuple[Day, ...], Meta(min_length=1, max_length=7)] = DAYS
    """Days on which it begins."""


class WorkingHours(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """When somebody works."""

    shifts: Annotated[tuple[WeeklySpan, ...], Meta(min_length=1, max_length=50)]
    breaks: Annotated[tuple[WeeklySpan, ...], Meta(max_length=50)] = ()
    """Taken out of the shifts, whichever they fall into."""
    holidays: Annotated[tuple[IsoDate, ...], Meta(max_length=1000)] = ()
    """Dates on which no shift begins."""


class WorkingTime:
    """The calendar of one machine, of the people of an area, or of the plant. Times are of the plant's clock, in seconds.

    Args:
        hours: its shifts; None for always.
        time_zone: of `hours`, by its IANA name.
    """

    def __init__(self, hours: WorkingHours | None, time_zone: str = "UTC") -> None:
        self._hours, self._time_zone = hours, time_zone
        self._days: dict[int, tuple[Span, ...]] = {}
        """Working spans of the shifts by day since 1970; computed once."""

    @cached_property
    def _zone(self) -> ZoneInfo:
        return ZoneInfo(self._time_zone)

    @cached_property
    def _holidays(self) -> frozenset[date]:
        return (
            frozenset() if self._hours is None else frozenset(map(date.fromisoformat, self._hours.holidays))
        )

    @property
    def is_always(self) -> bool:
        """Whether it never rests."""
        return self._hours is None

    def is_on(self, now_s: float) -> bool:
        """Whether it works at this moment."""
        return self._hours is None or self.next_on_s(now_s) == now_s

    def next_on_s(self, now_s: float) -> float:
        """First working time from `now_s` on; infinite for never."""
        if self._hours is None:
            return now_s
        return next((max(start_s, now_s) for start_s, _ in self._from(now_s)), float("inf"))

    def next_change_s(self, now_s: float) -> float:
        """When it begins to work or to rest, after `now_s`: not later than that, and infinite for never."""
        if self._hours is None:
            return float("inf")
        span = next(self._from(now_s), None)
        if span is None:
            return float("inf")
        return span[0] if span[0] > now_s else span[1]

    def after_s(self, start_s: float, work_s: float) -> float:
        """When so much working time has passed since `start_s`; infinite for never."""
        if self._hours is None or work_s <= 0.0:
            return start_s + work_s
        left_s = work_s
        for begins_s, ends_s in self._from(start_s):
            from_s = max(begins_s, start_s)
            if ends_s - from_s >= left_s:
                return from_s + left_s
            left_s -= ends_s - from_s
        return float("inf")

    def rests_s(self, start_s: float, work_s: float) -> float:
        """The rests that come until so much working time has passed; infinite for never."""
        # A difference of two times may miss 0 by its last bits.
        return 0.0 if self._hours is None else max(0.0, self.after_s(start_s, work_s) - start_s - work_s)

    def before_s(self, end_s: float, work_s: float) -> float:
        """When to begin so that so much working time has passed by `end_s`; `end_s - work_s` where there never was as much."""
        if self._hours is None or work_s <= 0.0:
            return end_s - work_s
        left_s = work_s
        for begins_s, ends_s in self._back_from(end_s):
            if ends_s - begins_s >= left_s:
                return ends_s - left_s
            left_s -= ends_s - begins_s
        return end_s - work_s

    def between_s(self, start_s: float, end_s: float) -> float:
        """Working time from one moment to a later one; below 0 for an earlier one."""
        if self._hours is None:
            return end_s - start_s
        if end_s < start_s:
            return -self.between_s(end_s, start_s)
        worked_s = 0.0
        for begins_s, ends_s in self._from(start_s):
            if begins_s >= end_s:
                break
            worked_s += min(ends_s, end_s) - max(begins_s, start_s)
        return worked_s

    # --- spans: those of several days, whole where one day's shift goes on in the next one's ---

    def _from(self, now_s: float, until_s: float = float("inf")) -> Iterator[Span]:
        """The spans that end after `now_s`, in order, at least up to `until_s`."""
        # A shift of the day before may last into this one, and a zone is less than a day off.
        first = int(now_s // DAY_S) - 2
        open_span: Span | None = None
        for day in range(first, first + DAYS_MAX):
            if (day - 1) * DAY_S > until_s:
                break
            for begins_s, ends_s in self._of(day):
                if open_span is None or begins_s > open_span[1]:
                    follows = begins_s, ends_s
                elif ends_s <= open_span[1]:
                    continue
                elif open_span[1] < open_span[0] + JOINED_MAX_S:
                    open_span = open_span[0], ends_s
                    continue
                else:
                    follows = open_span[1], ends_s
                if open_span is not None and open_span[1] > now_s:
                    yield open_span
                open_span = follows
        if open_span is not None and open_span[1] > now_s:
            yield open_span

    def _back_from(self, end_s: float) -> Iterator[Span]:
        """The spans that begin before `end_s`, the last one first, in pieces of a week at most."""
        until_s = end_s
        while until_s > end_s - DAYS_MAX * DAY_S:
            from_s = until_s - WEEK_S
            spans = [span for span in self._from(from_s, until_s) if span[0] < until_s]
            for begins_s, ends_s in reversed(spans):
                yield max(begins_s, from_s), min(ends_s, until_s)
            until_s = from_s

    def _of(self, day: int) -> tuple[Span, ...]:
        """Working spans of the shifts that begin on a local day."""
        known = self._days.get(day)
        if known is None:
            if len(self._days) >= DAYS_MAX:
                self._days.clear()
            known = self._days[day] = tuple(self._reckon(date(1970, 1, 1) + timedelta(days=day)))
        return known

    def _reckon(self, day: date) -> Iterator[Span]:
        hours = self._hours
        if hours is None or day in self._holidays:
            return
        shifts = sorted(self._spans(hours.shifts, day))
        # A break may belong to a shift that has begun the day before, or lasts into the next one.
        near = (day + timedelta(days=off) for off in (-1, 0, 1))
        breaks = sorted(span for each in near for span in self._spans(hours.breaks, each))
        rests = _joined(breaks)
        for start_s, end_s in _joined(shifts):
            from_s = start_s
            for rest_start_s, rest_end_s in rests:
                if from_s < min(rest_start_s, end_s):
                    yield from_s, min(rest_start_s, end_s)
                from_s = max(from_s, min(rest_end_s, end_s))
            if from_s < end_s:
                yield from_s, end_s

    def _spans(self, weekly: Iterable[WeeklySpan], day: date) -> Iterator[Span]:
        """The spans that begin on a day."""
        name = DAYS[day.weekday()]
        for each in weekly:
            if name in each.days:
                ends_on = day if each.end > each.start else day + timedelta(days=1)
                yield self._moment_s(day, each.start), self._moment_s(ends_on, each.end)

    def _moment_s(self, day: date, time_of_day: str) -> float:
        """Moment of a local time; one that the clocks skip counts as if they did not, one that comes twice is the first."""
        hour, minute = map(int, time_of_day.split(":"))
        local = datetime(day.year, day.month, day.day, hour, minute, tzinfo=self._zone)
        return local.astimezone(UTC).timestamp()


def _joined(spans: list[Span]) -> list[Span]:
    """The same time, each moment of it once."""
    joined: list[Span] = []
    for span in spans:
        if joined and span[0] <= joined[-1][1]:
            joined[-1] = joined[-1][0], max(joined[-1][1], span[1])
        else:
            joined.append(span)
    return joined
