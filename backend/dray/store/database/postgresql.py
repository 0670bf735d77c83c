"""PostgreSQL: a server, with any number of writing processes.

They queue for one lock, as SQLite's writers queue for the file. The factory writes a few transactions a second, so the
queue is short, and queries are the same on both databases.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from types import MappingProxyType
from typing import Any, TypeVar

import asyncpg
from sqlalchemy import Connection, text
from sqlalchemy.exc import DBAPIError, IntegrityError
from sqlalchemy.exc import TimeoutError as PoolTimeout
from sqlalchemy.ext.asyncio import AsyncConnection, AsyncEngine, create_async_engine

from dray.store.database import dialect

T = TypeVar("T")

WRITERS = 0x44726179
"""The advisory lock of all writers; "Dray" in ASCII. Such a lock belongs to one database."""

CONNECT_S = 5.0
"""Timeout of a connection: a slower server counts as absent."""

COMMAND_S = 60.0
"""Timeout of one statement: the longest is the creation of an index in a migration. A server behind a silent network is
given up after this."""

FORGOTTEN_MS = 60_000
"""A transaction idle for so long belongs to a hung process; others wait for its lock."""

_BEGIN = f"BEGIN ISOLATION LEVEL READ COMMITTED; SELECT pg_advisory_xact_lock({WRITERS})"
"""The beginning of a transaction with the writers' lock, in one message to the server."""

_AWAY = frozenset({"08", "25", "40", "53", "55", "57", "58"})
"""Classes of SQLSTATE for an unavailable server, not an error in the request: connection lost, read-only standby, rolled back,
no resources, lock not available, server being stopped, system error."""


class Postgresql:
    """See `dray.store.database.dialect.Dialect`."""

    reading: Mapping[str, Any] = MappingProxyType(
        {"isolation_level": "REPEATABLE READ", "postgresql_readonly": True}
    )
    # Each statement must see everything committed while its transaction waited for the lock.
    writing: Mapping[str, Any] = MappingProxyType({"isolation_level": "READ COMMITTED"})

    def __init__(self) -> None:
        self._kept: AsyncConnection | None = None
        """The connection of `do`, which begins and ends transactions itself. The pool would test it before each use, and each
        statement at a transaction's beginning costs a round trip."""

    def engine(self, url: str) -> AsyncEngine:
        server_settings = {
            "application_name": "dray",
            # An order answered with 201 must be on disk even when the power fails right after it.
            "synchronous_commit": "on",
            "lock_timeout": str(dialect.BUSY_TIMEOUT_MS),
            "idle_in_transaction_session_timeout": str(FORGOTTEN_MS),
            # Compiling costs more than any of our queries.
            "jit": "off",
        }
        connect: dict[str, Any] = {
            "timeout": CONNECT_S,
            "command_timeout": COMMAND_S,
            "server_settings": server_settings,
        }
        return create_async_engine(url, connect_args=connect, pool_pre_ping=True)

    async def knock(self, engine: AsyncEngine) -> None:
        """Do nothing: a failed attempt leaks nothing."""

    async def take_turn(self, connection: AsyncConnection) -> None:
        """Take the lock, held until the transaction ends in any way."""
        await connection.execute(text("SELECT pg_advisory_xact_lock(:writers)"), {"writers": WRITERS})

    async def do(self, writer: AsyncEngine, work: Callable[[Connection], T]) -> T:
        connection = await self._begun(writer)
        try:
            done = await connection.run_sync(work)
            await _say(connection, "COMMIT")
        except BaseException:
            await self._hang_up()
            raise
        return done

    async def at_once(self, writer: AsyncEngine, make: Callable[[], dialect.AtOnce[T] | None]) -> T | None:
        whole = make()
        if whole is None:
            return None
        fresh = self._kept is None
        try:
            return await self._written(writer, whole)
        except DBAPIError as error:
            if fresh or not _is_gone(error):
                raise
            # The server was restarted while idle; or it has written this already, and then the retry finds nothing new.
            done = await self._written(writer, whole)
            if done is None:
                raise
            return done

    async def _written(self, writer: AsyncEngine, whole: dialect.AtOnce[T]) -> T | None:
        try:
            driver = await _driver(await self._connected(writer))
            with _raised(whole.statement):
                written = await driver.fetchval(whole.statement, *whole.arguments)
        except IntegrityError:
            return None
        except BaseException:
            await self._hang_up()
            raise
        return whole.done if written else None

    async def close(self, engine: AsyncEngine) -> None:
        await self._hang_up()
        await engine.dispose()

    async def _begun(self, writer: AsyncEngine) -> AsyncConnection:
        """The kept connection in a transaction, or a new one if the server was away."""
        while True:
            fresh = self._kept is None
            try:
                await _say(await self._connected(writer), _BEGIN)
            except BaseException as error:
                await self._hang_up()
                if fresh or not _is_gone(error):
                    raise
            else:
                assert self._kept is not None  # noqa: S101 - it has just answered
                return self._kept

    async def _connected(self, writer: AsyncEngine) -> AsyncConnection:
        """The kept connection; a new one where there is none, or the server has closed it."""
        if self._kept is not None and (await _driver(self._kept)).is_closed():
            await self._hang_up()
        if self._kept is None:
            self._kept = await writer.connect()
            await self._kept.execution_options(isolation_level="AUTOCOMMIT")
        return self._kept

    async def _hang_up(self) -> None:
        """Close the connection; the server undoes uncommitted work."""
        if self._kept is not None:
            kept, self._kept = self._kept, None
            await kept.invalidate()
            await kept.close()

    def is_away(self, error: Exception) -> bool:
        """Whether the server is absent, stopping, starting, or out of resources."""
        if isinstance(error, DBAPIError):
            state: str | None = getattr(error.orig, "sqlstate", None)
            return error.connection_invalidated or (state or "")[:2] in _AWAY
        return isinstance(error, OSError | PoolTimeout)

    def remedy(self, reason: str) -> str:
        return "see that the server runs and DRAY_DATABASE_URL names it, its user and its password"


def _is_gone(error: BaseException) -> bool:
    """Whether the connection itself has failed, as after a restart of the server."""
    if isinstance(error, DBAPIError):
        state: str | None = getattr(error.orig, "sqlstate", None)
        return error.connection_invalidated or (state or "")[:2] in {"08", "57"}
    return isinstance(error, OSError)


async def _say(connection: AsyncConnection, command: str) -> None:
    """Send the server a command, in the simple protocol that allows several statements.

    Raises:
        DBAPIError: as SQLAlchemy would raise it.
    """
    driver = await _driver(connection)
    with _raised(command):
        await driver.execute(command)


async def _driver(connection: AsyncConnection) -> Any:
    return (await connection.get_raw_connection()).driver_connection


@contextmanager
def _raised(command: str) -> Iterator[None]:
    """Convert the driver's exceptions as SQLAlchemy would.

    Raises:
        DBAPIError: an `IntegrityError` for a row that exists already.
    """
    try:
        yield
    except asyncpg.UniqueViolationError as error:
        raise IntegrityError(command, None, error) from error
    except (asyncpg.PostgresError, asyncpg.InterfaceError, asyncpg.InternalClientError) as error:
        # Without an error of the server, the driver finds the connection closed, or closing.
        gone = not isinstance(error, asyncpg.PostgresError)
        raise DBAPIError(command, None, error, connection_invalidated=gone) from error
