"""The change feed: what has changed of orders and transports, for systems that follow them, and waiting for the next change.

Whoever waits holds neither a connection to the database nor a thread: one look at the newest position serves all who wait.
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
"""Wall seconds between two looks at what is new while somebody waits: what another gateway on the database does is seen no sooner."""

WAITING_MOST = 200
"""Requests that may wait at once. Each costs some kilobytes."""

WAIT_S = 30.0
"""The longest wait: shorter than what proxies on the way grant an answer."""


class Changes(msgspec.Struct, frozen=True):
    """A part of the log."""

    rows: Sequence[Change]
    until: int
    """All changes up to this position are among these, or before them."""
    more: bool
    """Whether there are some behind it."""
    is_forgotten: bool = False
    """What comes after the position that was asked for is not kept any more, or never was there: the log is another one."""


class ChangeFeed:
    """Tells what has changed.

    Args:
        store: where it is kept.

    Attributes:
        waiting: by caller, how many of its requests wait.
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
        """What has changed since a position; where nothing has, the next change is waited for.

        Args:
            since: the position up to which all is known.
            seen: which changes are shown.
            limit: how many at most.
            caller: who asks.
            wait_s: for how long it waits at most; 0 for not at all.

        Raises:
            Problem: the caller waits in as many requests as one may.
            UnavailableError: the database cannot be read.
        """
        found = await self._read(since, seen, limit)
        if found.rows or found.is_forgotten or wait_s <= 0.0:
            return found
        if self.waiting[caller] >= share_of(WAITING_MOST):
            raise share_used(
                "requests that wait for changes", WAITING_MOST, "let one that waits be answered", again_s=1
            )
        self.waiting[caller] += 1
        try:
            async with asyncio.timeout(wait_s):
                while not found.rows and not found.is_forgotten:
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
                return Changes((), since, more=False, is_forgotten=True)
            rows = await work.change_log.page(since, newest, seen, limit + 1)
        more = len(rows) > limit
        return Changes(rows[:limit], rows[limit - 1].position if more else newest, more)

    async def _changed(self, known: int) -> None:
        """Return when there is a change behind a position."""
        while self._newest <= known:
            if self._look is None or self._look.done():
                self._look = asyncio.create_task(self._look_soon())
            # Who gives up waiting must not take the look from the others.
            await asyncio.shield(self._look)

    async def _look_soon(self) -> None:
        await asyncio.sleep(LOOK_EVERY_S)
        self._newest = await self.newest()
