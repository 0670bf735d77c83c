"""The database: opening it, and serialising its transactions.

Both databases have one writer at a time. Writers of this process queue here in order, so that many of them use one
connection. Writers of other processes queue in the database (`dray.store.database.dialect`). A commit returns when it is on
disk.
"""

from __future__ import annotations

import asyncio
import logging
import sqlite3
import time
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import asynccontextmanager, contextmanager
from typing import TypeVar

from sqlalchemy import Connection, QueuePool, text
from sqlalchemy.exc import ArgumentError, DBAPIError
from sqlalchemy.exc import TimeoutError as PoolTimeout
from sqlalchemy.ext.asyncio import AsyncConnection, AsyncEngine

from dray.errors import UnavailableError
from dray.store.database.dialect import AtOnce, Dialect
from dray.store.database.postgresql import Postgresql
from dray.store.database.sqlite import Sqlite

_log = logging.getLogger(__name__)

T = TypeVar("T")

_FAULTS = (DBAPIError, PoolTimeout, OSError, sqlite3.Error)
"""Exceptions of drivers, as opposed to our own bugs."""


class Outage:
    """The outages of one way to use a database: each one and its end are logged once.

    Args:
        what: the purpose, in words.
    """

    def __init__(self, what: str) -> None:
        self._what = what
        self._since_s: float | None = None
        self._refused = 0

    def begun(self, complaint: UnavailableError) -> None:
        """The database could not be used."""
        self._refused += 1
        if self._since_s is None:
            self._since_s = time.monotonic()
            _log.warning(
                "%s cannot be %s, and whoever asks is told so until it can: %s",
                complaint.what,
                self._what,
                complaint.reason,
            )

    def ended(self) -> None:
        """The database could be used."""
        if self._since_s is not None:
            away_s, self._since_s = time.monotonic() - self._since_s, None
            _log.warning(
                "the database can be %s again after %.0f s, in which %d asked in vain",
                self._what,
                away_s,
                self._refused,
            )
            self._refused = 0


class Database:
    """An open database.

    Args:
        engine: its engine; closed by `close`.
        dialect: its dialect.
    """

    def __init__(self, engine: AsyncEngine, dialect: Dialect) -> None:
        self.engine = engine
        self._dialect = dialect
        self._reader = engine.execution_options(**dialect.reading)
        self._writer = engine.execution_options(**dialect.writing)
        self._writing = asyncio.Lock()
        self._unread, self._unwritten = Outage("read"), Outage("written")

    @classmethod
    async def open(cls, url: str) -> Database:
        """Connect, and check that it is writable.

        Args:
            url: as `Settings.database_url`.

        Raises:
            UnavailableError: opening or writing failed; contains a remedy.
        """
        dialect: Dialect = Sqlite() if url.startswith("sqlite") else Postgresql()
        try:
            engine = dialect.engine(url)
        except (ArgumentError, ModuleNotFoundError) as error:
            raise UnavailableError(
                "database", str(error), "give DRAY_DATABASE_URL as sqlite:///dray.db, or install its driver"
            ) from error
        database = cls(engine, dialect)
        try:
            await dialect.knock(engine)
            await database._prove_writable()
        except _FAULTS as error:
            await database.close()
            raise database._complaint(error) from error
        return database

    @property
    def name(self) -> str:
        """Its name for people: the path of the file, or the URL without its password."""
        url = self.engine.url
        sqlite = url.get_backend_name() == "sqlite"
        return str(url.database) if sqlite else url.render_as_string(hide_password=True)

    @property
    def connections_used(self) -> int:
        """The number of connections in use."""
        pool = self.engine.pool
        return pool.checkedout() if isinstance(pool, QueuePool) else 0

    @asynccontextmanager
    async def read(self) -> AsyncIterator[AsyncConnection]:
        """A reading transaction: a consistent view, for which writers never wait.

        Raises:
            UnavailableError: reading is impossible at present.
        """
        with self._told(self._unread):
            async with self._reader.connect() as connection:
                yield connection

    @asynccontextmanager
    async def write(self) -> AsyncIterator[AsyncConnection]:
        """A transaction that is on disk when the block has ended, or undone when it raises.

        Raises:
            UnavailableError: writing is impossible at present. If the end of the block raises it, it is unknown whether the
                transaction was undone.
        """
        with self._told(self._unwritten):
            async with self._writing, self._writer.begin() as connection:
                await self._dialect.take_turn(connection)
                yield connection

    async def do(
        self, work: Callable[[Connection], T], at_once: Callable[[], AtOnce[T] | None] | None = None
    ) -> T:
        """Do something in a transaction of its own, in as few steps as this database allows.

        Args:
            work: called with the connection, perhaps in another thread.
            at_once: makes one statement with the same effect, or None; tried first where that is shorter. If it writes
                nothing, `work` is called.

        Returns:
            The result of `work`; by then it is on disk.

        Raises:
            UnavailableError: as `write`.
        """
        with self._told(self._unwritten):
            async with self._writing:
                if at_once is not None:
                    done: T | None = await self._dialect.at_once(self._writer, at_once)
                    if done is not None:
                        return done
                return await self._dialect.do(self._writer, work)

    async def close(self) -> None:
        """Close all connections; harmless when repeated."""
        await self._dialect.close(self.engine)

    @contextmanager
    def _told(self, outage: Outage) -> Iterator[None]:
        """Distinguish an unavailable database from an error in the request."""
        try:
            yield
        except _FAULTS as error:
            if self._dialect.is_away(error):
                complaint = self._complaint(error)
                outage.begun(complaint)
                raise complaint from error
            raise
        else:
            outage.ended()

    async def _prove_writable(self) -> None:
        """Try a write and undo it: BEGIN alone succeeds on a read-only file."""
        async with self._writer.connect() as connection, connection.begin() as transaction:
            await self._dialect.take_turn(connection)
            await connection.execute(text("CREATE TABLE dray_probe (probe INTEGER)"))
            await transaction.rollback()

    def _complaint(self, error: Exception) -> UnavailableError:
        reason = str(getattr(error, "orig", None) or error)
        return UnavailableError(f"database {self.name}", reason, self._dialect.remedy(reason))
