"""The change feed: changes of orders and transports for other systems, and waiting for the next one.

A waiting request holds neither a database connection nor a thread: one look at the newest position serves
all.
"""

from __future__ import annotations

import asyncio
from collections import Counter
from collections.abc import Sequence

import msgspec

from dray.gateway.http.shares import share_of, share_used
from dray.store import Store
from dray.store.orders.change_log import Change, Seen

LOOK_EVERY_S = 0.5
"""Wall seconds between two looks while a request waits: the delay for changes by another gateway."""

WAITING_MOST = 200
"""Maximum waiting requests. Each costs some kilobytes."""

WAIT_S = 30.0
"""Maximum wait in seconds: shorter than proxies' timeouts."""


class Changes(msgspec.Struct, frozen=True):
    """A part of the log."""

    rows: Sequence[Change]
    until: int
    """Position up to which all changes are here or came before."""
    more: bool
    """Whether more changes follow."""
    is_forgotten: bool = False
    """Whether the log no longer has the changes after the requested position."""
    is_ahead: bool = False
    """Whether the requested position comes after the newest one: this log has not given it out."""

    @property
    def is_empty(self) -> bool:
        """Whether there is nothing to tell yet."""
        return not (self.rows or self.is_forgotten or self.is_ahead)


class ChangeFeed:
    """Returns changes.

    Args:
        store: the database with the log.

    Attributes:
        waiting: number of waiting requests per caller.
    """

    def __init__(self, store: Store) -> None:
        self._store = store
        self._newest = 0
        self._look: asyncio.Task[None] | None = None
        self.waiting = Counter[str]()

    async def newest(self) -> int:
        """The position of the newest change."""
        async with self._store.read() as work:
            return (await work.change_log.ends())[1]

    async def after(self, since: int, seen: Seen, limit: int, *, caller: str, wait_s: float = 0.0) -> Changes:
        """The changes after a position; if there are none, wait for the next.

        Args:
            since: the last position known.
            seen: which changes are shown.
            limit: maximum changes.
            caller: the caller.
            wait_s: maximum wait in seconds; 0 for no wait.

        Raises:
            Problem: the caller has its maximum of waiting requests.
            UnavailableError: the database cannot be read.
        """
        found = await self._read(since, seen, limit)
        if not found.is_empty or wait_s <= 0.0:
            return found
        if self.waiting[caller] >= share_of(WAITING_MOST):
            raise share_used(
                "requests that wait for changes", WAITING_MOST, "let one that waits be answered", again_s=1
            )
        self.waiting[caller] += 1
        try:
            async with asyncio.timeout(wait_s):
                while found.is_empty:
                    await self._changed(found.until)
                    found = await self._read(found.until, seen, limit)
        except TimeoutError:
            pass
        finally:
            self.waiting[caller] -= 1
            if not self.waiting[caller]:
                del self.waiting[caller]
        return found

    async def _read(self, since: int, seen: Seen, limit: int) -> Changes:
        async with self._store.read() as work:
            oldest, newest = await work.change_log.ends()
            if not oldest <= since <= newest:
                return Changes((), since, more=False, is_forgotten=since < oldest, is_ahead=since > newest)
            rows = await work.change_log.page(since, newest, seen, limit + 1)
        more = len(rows) > limit
        return Changes(rows[:limit], rows[limit - 1].position if more else newest, more)

    async def _changed(self, known: int) -> None:
        """Return once there is a change after a position."""
        while self._newest <= known:
            if self._look is None or self._look.done():
                self._look = asyncio.create_task(self._look_soon())
            # A cancelled waiter must not cancel the look of the others.
            await asyncio.shield(self._look)

    async def _look_soon(self) -> None:
        await asyncio.sleep(LOOK_EVERY_S)
        self._newest = await self.newest()
