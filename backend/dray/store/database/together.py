"""Group commit: items that wait during a commit are written together by the next one.

A commit waits for the disk, which takes as long for one item as for a hundred. So one writer takes all waiting items, writes
them in one transaction, and answers when that is on disk. If one of them cannot be written, the transaction is undone and
each is tried alone. So no item fails because of another one.
"""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import Callable, Sequence
from typing import Generic, TypeVar

from sqlalchemy import Connection

from dray.errors import UnavailableError
from dray.store.database.database import Database
from dray.store.database.dialect import AtOnce

In = TypeVar("In")
Out = TypeVar("Out")

AT_ONCE = 100
"""Maximum items in one transaction: more would delay the first for the sake of the last."""

WAITING = 1_000
"""Maximum waiting items: some seconds of the slowest disk. Further ones are refused and may be retried."""


class Together(Generic[In, Out]):
    """Writes concurrent items in one transaction.

    Args:
        database: the database.
        write: writes some items in one transaction, in order, and returns their results. It may run in another thread, and again
            when the transaction was undone.
        at_once: see `Database.do`.
    """

    def __init__(
        self,
        database: Database,
        write: Callable[[Connection, Sequence[In]], Sequence[Out]],
        at_once: Callable[[Sequence[In]], AtOnce[Sequence[Out]] | None],
    ) -> None:
        self._database, self._write, self._at_once = database, write, at_once
        self._waiting: deque[tuple[In, asyncio.Future[Out]]] = deque()
        self._writer: asyncio.Task[None] | None = None

    async def do(self, item: In) -> Out:
        """Write one item; it is on disk when this returns. A cancelled caller does not undo it.

        Raises:
            UnavailableError: writing is impossible at present, or too many items wait.
        """
        if len(self._waiting) >= WAITING:
            raise UnavailableError(
                f"database {self._database.name}",
                f"{WAITING} requests wait to be written",
                "try again in some seconds; if it lasts, the disk is too slow",
            )
        written: asyncio.Future[Out] = asyncio.get_running_loop().create_future()
        self._waiting.append((item, written))
        if self._writer is None or self._writer.done():
            self._writer = asyncio.create_task(self._run())
        return await written

    async def _run(self) -> None:
        while self._waiting:
            batch = [self._waiting.popleft() for _ in range(min(AT_ONCE, len(self._waiting)))]
            if not await self._written(batch, alone=len(batch) == 1):
                for each in batch:
                    await self._written([each], alone=True)

    async def _written(self, batch: Sequence[tuple[In, asyncio.Future[Out]]], *, alone: bool) -> bool:
        """Write some items and answer; False when nothing was written and each must be tried alone."""
        try:
            items = [one for one, _ in batch]
            done = await self._database.do(
                lambda connection: self._write(connection, items), lambda: self._at_once(items)
            )
        except BaseException as error:
            if not (alone or isinstance(error, UnavailableError | asyncio.CancelledError)):
                return False
            for _, written in batch:
                if isinstance(error, asyncio.CancelledError):
                    written.cancel()
                elif not written.done():
                    written.set_exception(error)
            if not isinstance(error, Exception):
                raise
            return True
        for (_, written), out in zip(batch, done, strict=True):
            if not written.done():
                written.set_result(out)
        return True
