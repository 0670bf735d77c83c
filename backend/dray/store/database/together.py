"""Together: what waits to be written while another commit is on its way is written by the next one, all at once.

A commit waits for the disk, which takes as long for one as for a hundred. So there is one writer: it takes whatever
waits, writes it in one transaction, and answers when that is on disk. When something in it cannot be written, the
transaction is undone and each is tried alone, so nobody fails for another one's sake.
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
"""Written in one transaction: more would make the first of them wait longer for the sake of the last."""

WAITING = 1_000
"""That wait for their turn: some seconds of the slowest disk. Whoever finds no place is told to come again."""


class Together(Generic[In, Out]):
    """Writes what comes together in one transaction.

    Args:
        database: where to.
        write: writes some in one transaction, in their order, and returns what became of each. It may run in another
            thread, and again when the transaction was undone.
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
        """Write one; it is on disk when this returns. Whoever is cancelled meanwhile does not undo it.

        Raises:
            UnavailableError: the database cannot be written at present, or too many wait for it.
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
        """Write some and answer; False when nothing was done and each is to be tried alone."""
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
