"""Retention: old data is deleted by its age, in small transactions with pauses, so that other writers wait little.

Data for the pages of an order and of its customer is stored with the order before the log deletes it. There is a bound on rows, too,
so that no plant fills its disk. It should never be reached, and reaching it is reported.
"""

from __future__ import annotations

import asyncio
import logging
import time
from collections.abc import Awaitable, Callable
from typing import NamedTuple

import msgspec

from dray.store.work import Store, Work
from dray.supervision import keep_looking

DAY_S = 86_400.0

LOOK_EVERY_S = 60.0
"""Wall seconds between two checks for old data."""

AT_ONCE = 200
"""Maximum rows deleted in one transaction: some milliseconds, in which nobody else writes."""

PAUSE_S = 0.02
"""Minimum wall seconds between two of these, for other writers."""

REST = 2.0
"""Pauses as a multiple of the work before them: a third of a processor at most. Above the maximum of rows there are no such pauses."""

TURN = 50
"""Transactions per kind before the next kind: a log that grows as fast as it is deleted must not block the others."""

_log = logging.getLogger(__name__)


class KeptFor(msgspec.Struct, frozen=True, kw_only=True):
    """Retention of each kind in wall seconds, since the event or the end."""

    events_s: float
    samples_s: float
    figures_s: float
    tasks_s: float
    transports_s: float
    alerts_s: float
    audit_s: float
    events_most: int
    """Maximum rows of the event log, of any age."""


class Forgotten(NamedTuple):
    """The result of one transaction.

    Attributes:
        rows: number of deleted rows; fewer than `AT_ONCE` when no more are too old.
        worked_s: its duration.
        too_many: number of rows deleted before their time, because there were too many.
    """

    rows: int
    worked_s: float = 0.0
    too_many: int = 0


class Retention:
    """Deletes old data.

    Args:
        store: the store.
        kept_for: the retention of each kind.
        wall_s: the wall clock.
    """

    def __init__(self, store: Store, kept_for: KeptFor, wall_s: Callable[[], float]) -> None:
        self._store, self._kept_for, self._wall_s = store, kept_for, wall_s
        self.too_many = 0
        """Number of events deleted before their time, because there were too many."""
        self._clock = time.monotonic

    async def run(self) -> None:
        """Delete until cancelled."""
        await keep_looking(
            self.forget,
            LOOK_EVERY_S,
            lambda error: _log.warning("what is too old is not forgotten yet: %s", error),
        )

    async def forget(self) -> None:
        """Delete all that is too old now.

        Raises:
            UnavailableError: writing failed; earlier deletions stay.
        """
        has_more = True
        while has_more:
            before = self.too_many
            turns = [await self._turn(some) for some in self._kinds(self._wall_s())]
            has_more = any(turns)
            if self.too_many > before:
                _log.warning(
                    "%d events were forgotten before their time: there are more than DRAY_EVENTS_MOST=%d; make it more where "
                    "the disk has room, or keep them for fewer days (DRAY_EVENTS_DAYS)",
                    self.too_many - before,
                    self._kept_for.events_most,
                )

    def _kinds(self, now_s: float) -> tuple[Callable[[], Awaitable[Forgotten]], ...]:
        """Functions that each delete some rows of one kind."""
        kept = self._kept_for
        return (
            lambda: self._events(now_s - kept.events_s, now_s),
            lambda: self._rows(lambda work: work.change_log.prune(now_s - kept.events_s, AT_ONCE)),
            lambda: self._rows(lambda work: work.samples.prune(now_s - kept.samples_s, AT_ONCE, now_s)),
            lambda: self._rows(lambda work: work.kpis.prune(now_s - kept.figures_s, AT_ONCE)),
            lambda: self._rows(lambda work: work.piece_hours.prune(now_s - kept.figures_s, AT_ONCE)),
            lambda: self._rows(lambda work: work.takeovers.prune(now_s - kept.figures_s, AT_ONCE)),
            lambda: self._rows(lambda work: work.tasks.prune(now_s - kept.tasks_s, AT_ONCE)),
            lambda: self._rows(lambda work: work.transports.prune(now_s - kept.transports_s, AT_ONCE)),
            lambda: self._rows(lambda work: work.alerts.prune(now_s - kept.alerts_s, AT_ONCE)),
            lambda: self._rows(lambda work: work.audit.prune(now_s - kept.audit_s, AT_ONCE)),
        )

    async def _turn(self, some: Callable[[], Awaitable[Forgotten]]) -> bool:
        """Delete rows of one kind; returns whether there may be more."""
        for _ in range(TURN):
            done = await some()
            rest_s = 0.0 if done.too_many else REST * done.worked_s
            await asyncio.sleep(max(PAUSE_S, rest_s))
            if done.rows < AT_ONCE:
                return False
        return True

    async def _rows(self, prune: Callable[[Work], Awaitable[int]]) -> Forgotten:
        async with self._store.write() as work:
            # Waiting for other writers does not count as work.
            begun_s = self._clock()
            rows = await prune(work)
        return Forgotten(rows, self._clock() - begun_s)

    async def _events(self, before_s: float, now_s: float) -> Forgotten:
        # The orders' histories are built while others may write.
        async with self._store.read() as work:
            begun_s = self._clock()
            found = await work.events.oldest(before_s, self._kept_for.events_most, AT_ONCE, now_s)
            if found is None:
                return Forgotten(0)
            first, last, too_many = found
            histories = await work.order_histories.gathered(first, last)
        read_s = self._clock() - begun_s
        async with self._store.write() as work:
            begun_s = self._clock()
            # Another historian may have deleted them meanwhile, and more: then the histories read here are outdated.
            if await work.events.first() == first:
                await work.order_histories.put(histories)
                await work.events.forget(first, last)
                self.too_many += too_many
        return Forgotten(last - first + 1, read_s + self._clock() - begun_s, too_many)
