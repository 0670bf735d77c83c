"""SQLite: a local file, with one writer at a time.

A write transaction locks the file when it begins (BEGIN IMMEDIATE): a lock taken later, after a read, could not be
waited for.
"""

from __future__ import annotations

import asyncio
import sqlite3
import threading
import time
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing, suppress
from pathlib import Path
from types import MappingProxyType
from typing import Any, TypeVar

import aiosqlite
from sqlalchemy import URL, Connection, Engine, NullPool, create_engine, event
from sqlalchemy.exc import DBAPIError, InterfaceError, OperationalError
from sqlalchemy.ext.asyncio import AsyncConnection, AsyncEngine, create_async_engine

from dray.store.database import dialect

T = TypeVar("T")

_IMMEDIATE = "dray_immediate"

CHECKPOINT_PAGES = 8_000
"""Pages of the write-ahead log, 32 MB, after which a commit copies them into the file and waits for the disk twice more. An
order changes some twenty pages, mostly those of earlier orders."""

ANSWER_WAIT_S = 5.0
"""Longest wait, on closing, for the threads of abandoned connections."""


class Sqlite:
    """See `dray.store.database.dialect.Dialect`."""

    reading: Mapping[str, Any] = MappingProxyType({})
    writing: Mapping[str, Any] = MappingProxyType({_IMMEDIATE: True})

    def __init__(self) -> None:
        self._direct: Connection | None = None
        """A connection to the same file for a thread that runs whole transactions: aiosqlite would switch threads some twenty times
        in each."""
        self._thread = ThreadPoolExecutor(max_workers=1, thread_name_prefix="sqlite")
        self._threads: list[threading.Thread] = []
        """The threads of aiosqlite's connections, until they end."""
        self._closed = False

    def engine(self, url: str) -> AsyncEngine:
        engine = create_async_engine(url, connect_args={"factory": _Connection})
        _listen(engine.sync_engine)
        event.listen(engine.sync_engine, "do_connect", self._keep_thread)
        return engine

    def _keep_thread(self, _dialect: Any, _record: Any, _args: Any, keywords: dict[str, Any]) -> None:
        keywords["async_creator_fn"] = self._open

    def _open(self, *args: Any, **keywords: Any) -> aiosqlite.Connection:
        connection = aiosqlite.connect(*args, **keywords)
        thread = connection._thread  # noqa: SLF001 - as SQLAlchemy itself does, there is no other way to it.
        thread.daemon = True
        self._threads = [*filter(threading.Thread.is_alive, self._threads), thread]
        return connection

    async def do(self, writer: AsyncEngine, work: Callable[[Connection], T]) -> T:
        return await asyncio.get_running_loop().run_in_executor(self._thread, self._do, writer.url, work)

    async def at_once(self, writer: AsyncEngine, make: Callable[[], dialect.AtOnce[T] | None]) -> T | None:
        """Do nothing: the file is local, so several statements are as fast."""
        return None

    def _do(self, url: URL, work: Callable[[Connection], T]) -> T:
        if self._direct is None:
            self._direct = self._connect(url)
        try:
            with self._direct.begin():
                return work(self._direct)
        except BaseException:
            # After any error the next transaction uses a new connection.
            self._hang_up()
            raise

    def _connect(self, url: URL) -> Connection:
        engine = create_engine(url.set(drivername="sqlite"), poolclass=NullPool)
        _listen(engine)
        return engine.execution_options(**self.writing).connect()

    def _hang_up(self) -> None:
        if self._direct is not None:
            direct, self._direct = self._direct, None
            direct.close()

    async def close(self, engine: AsyncEngine) -> None:
        if not self._closed:
            self._closed = True
            await asyncio.get_running_loop().run_in_executor(self._thread, self._hang_up)
            self._thread.shutdown(wait=False)
        await engine.dispose()
        await asyncio.to_thread(self._wait_for_threads)

    def _wait_for_threads(self) -> None:
        # A cancelled task may have left a thread that still answers to the loop, which may be closed next.
        until_s = time.monotonic() + ANSWER_WAIT_S
        for thread in self._threads:
            thread.join(max(0.0, until_s - time.monotonic()))

    async def knock(self, engine: AsyncEngine) -> None:
        """Check the path: a failed attempt of aiosqlite would leave a thread that may answer to a closed loop."""
        await asyncio.to_thread(_open_once, engine.url.database or "")

    async def take_turn(self, connection: AsyncConnection) -> None:
        """Do nothing: BEGIN IMMEDIATE has the lock."""

    def is_away(self, error: Exception) -> bool:
        """Whether it is a full disk, a lock held for too long, a missing folder, or a damaged file."""
        if isinstance(error, DBAPIError) and isinstance(error.orig, sqlite3.Error):
            # aiosqlite passes on SQLite's errors.
            return isinstance(error, OperationalError | InterfaceError) or _is_damage(error.orig)
        return isinstance(error, OperationalError | InterfaceError | sqlite3.Error | OSError)

    def remedy(self, reason: str) -> str:
        if "not a database" in reason:
            return (
                "it is some other file, or damaged at its beginning: name another one with --db or "
                "DRAY_DATABASE_URL, or put a backup in its place"
            )
        if "malformed" in reason or "unsupported file format" in reason:
            return (
                "it is damaged: end what uses it and move it away, then put a backup in its place, or what "
                "`sqlite3 FILE .recover` still finds in it"
            )
        if "locked" in reason:
            return "another process is writing to it: end it, or name another file with --db"
        return (
            "see that its folder exists and may be written to and that the disk is not full, "
            "or name another file with --db or DRAY_DATABASE_URL"
        )


class _Connection(sqlite3.Connection):
    """Undoes an open transaction before it closes.

    Otherwise SQLite keeps the transaction, and the file's lock, as long as a half-read cursor exists
    (https://sqlite.org/c3ref/close.html). The exception of a cancelled task may hold one.
    """

    def close(self) -> None:
        with suppress(sqlite3.Error):
            self.rollback()
        super().close()


def _open_once(path: str) -> None:
    # It contains the key that signs commands, so only its owner may read it. SQLite reports a failed creation.
    with suppress(OSError):
        Path(path).touch(mode=0o600)
    with closing(sqlite3.connect(path)) as base:
        try:
            base.execute("SELECT name, sql FROM sqlite_schema").fetchall()
        except UnicodeDecodeError:
            # The driver cannot even decode SQLite's error about its names.
            raise sqlite3.DatabaseError("database disk image is malformed") from None


def _is_damage(error: BaseException) -> bool:
    """Whether SQLite reports damaged bytes."""
    code: int = getattr(error, "sqlite_errorcode", 0)
    return code & 0xFF in (sqlite3.SQLITE_CORRUPT, sqlite3.SQLITE_NOTADB)


def _listen(engine: Engine) -> None:
    event.listen(engine, "connect", _prepare)
    event.listen(engine, "begin", _begin)


def _prepare(connection: Any, _record: Any) -> None:
    # The driver would begin transactions by itself, and only before some statements: `_begin` does it instead.
    connection.isolation_level = None
    cursor = connection.cursor()
    # FULL: an order answered with 201 must be on disk even when the power fails right after it.
    for pragma in (
        f"busy_timeout = {dialect.BUSY_TIMEOUT_MS}",
        "journal_mode = WAL",
        "synchronous = FULL",
        f"wal_autocheckpoint = {CHECKPOINT_PAGES}",
        "foreign_keys = ON",
    ):
        cursor.execute(f"PRAGMA {pragma}")
    cursor.close()


def _begin(connection: Connection) -> None:
    immediate = connection.get_execution_options().get(_IMMEDIATE, False)
    connection.exec_driver_sql("BEGIN IMMEDIATE" if immediate else "BEGIN")
