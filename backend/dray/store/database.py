"""The database: opening it, and one transaction at a time.

SQLite has one writer at a time, so writers queue here, in order, instead of in SQLite's own waiting
by sleeping. A write transaction takes the lock of the file when it begins (BEGIN IMMEDIATE):
a lock taken half way, after a read, could not be waited for. A commit returns when it is on disk.
"""

from __future__ import annotations

import asyncio
import sqlite3
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

from sqlalchemy import Connection, event, make_url, text
from sqlalchemy.exc import ArgumentError, DBAPIError
from sqlalchemy.ext.asyncio import AsyncConnection, AsyncEngine, create_async_engine

from dray.errors import UnavailableError

BUSY_TIMEOUT_MS = 5_000
"""How long to wait for another process's write: an upgrade or a backup takes seconds, no more."""

_IMMEDIATE = "dray_immediate"


class Database:
    """An open database.

    Args:
        engine: its engine; closed by `close`.
    """

    def __init__(self, engine: AsyncEngine) -> None:
        self.engine = engine
        self.is_sqlite = engine.dialect.name == "sqlite"
        self._writing = asyncio.Lock()

    @classmethod
    async def open(cls, url: str) -> Database:
        """Connect, and see that it can be written to.

        Args:
            url: as `Settings.database_url`.

        Raises:
            UnavailableError: with a remedy, when it cannot be opened or written.
        """
        try:
            engine = create_async_engine(url, pool_pre_ping=not url.startswith("sqlite"))
        except (ArgumentError, ModuleNotFoundError) as error:
            raise UnavailableError(
                "database", str(error), "give DRAY_DATABASE_URL as sqlite:///dray.db, or install its driver"
            ) from error
        if engine.dialect.name == "sqlite":
            event.listen(engine.sync_engine, "connect", _prepare_sqlite)
            event.listen(engine.sync_engine, "begin", _begin_sqlite)
        database = cls(engine)
        try:
            if database.is_sqlite:
                await asyncio.to_thread(_open_once, engine.url.database or "")
            await database._prove_writable()
        except (DBAPIError, OSError, sqlite3.Error) as error:
            await database.close()
            raise UnavailableError(*_complaint(url, error)) from error
        return database

    @asynccontextmanager
    async def read(self) -> AsyncIterator[AsyncConnection]:
        """A transaction that only reads: a consistent view, never waited for by writers."""
        async with self.engine.connect() as connection:
            yield connection

    @asynccontextmanager
    async def write(self) -> AsyncIterator[AsyncConnection]:
        """A transaction that is on disk when the block has ended, or undone when it raises."""
        async with self._writing, self.engine.connect() as connection:
            await connection.execution_options(**{_IMMEDIATE: True})
            async with connection.begin():
                yield connection

    async def close(self) -> None:
        """Close all connections; harmless when done twice."""
        await self.engine.dispose()

    async def _prove_writable(self) -> None:
        """Try a write and undo it: BEGIN alone does not tell on a file that may only be read."""
        async with self.engine.connect() as connection:
            await connection.execution_options(**{_IMMEDIATE: True})
            async with connection.begin() as transaction:
                await connection.execute(text("CREATE TABLE dray_probe (probe INTEGER)"))
                await transaction.rollback()


def _open_once(path: str) -> None:
    """Open and close the file. A failed attempt of aiosqlite leaves a thread that may answer to a closed loop."""
    sqlite3.connect(path).close()


def _prepare_sqlite(connection: Any, _record: Any) -> None:
    # The driver would begin transactions by itself, and only before some statements: `_begin_sqlite`
    # does it instead.
    connection.isolation_level = None
    cursor = connection.cursor()
    # FULL: an order that was answered 201 must be on disk even when the power fails right after it.
    for pragma in (
        f"busy_timeout = {BUSY_TIMEOUT_MS}",
        "journal_mode = WAL",
        "synchronous = FULL",
        "foreign_keys = ON",
    ):
        cursor.execute(f"PRAGMA {pragma}")
    cursor.close()


def _begin_sqlite(connection: Connection) -> None:
    immediate = connection.get_execution_options().get(_IMMEDIATE, False)
    connection.exec_driver_sql("BEGIN IMMEDIATE" if immediate else "BEGIN")


def _complaint(url: str, error: Exception) -> tuple[str, str, str]:
    """What, reason and remedy for a database that cannot be used."""
    parsed = make_url(url)
    reason = str(getattr(error, "orig", None) or error)
    if parsed.get_backend_name() != "sqlite":
        where = parsed.render_as_string(hide_password=True)
        return f"database {where}", reason, "see that the server runs and DRAY_DATABASE_URL names it"
    if "not a database" in reason:
        remedy = "it is some other file: name another one with --db or DRAY_DATABASE_URL"
    elif "locked" in reason:
        remedy = "another process is writing to it: end it, or name another file with --db"
    else:
        remedy = (
            "see that its folder exists and may be written to and that the disk is not full, "
            "or name another file with --db or DRAY_DATABASE_URL"
        )
    return f"database {parsed.database}", reason, remedy
