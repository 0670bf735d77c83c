"""The differences between SQLite and PostgreSQL; `sqlite` and `postgresql` implement them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Generic, Protocol, TypeVar

import msgspec
from sqlalchemy import Connection, Insert, Table
from sqlalchemy.dialects import postgresql, sqlite
from sqlalchemy.ext.asyncio import AsyncConnection, AsyncEngine

T = TypeVar("T")

BUSY_TIMEOUT_MS = 5_000
"""Longest wait for another process's write: an upgrade or a backup takes seconds, not more."""


class AtOnce(msgspec.Struct, Generic[T], frozen=True):
    """A writing transaction in one statement, which takes the writers' lock itself."""

    statement: str
    """In the driver's syntax; its only value tells whether it wrote anything."""
    arguments: tuple[object, ...]
    done: T
    """The result if it did."""


class Dialect(Protocol):
    """One kind of database.

    Attributes:
        reading: options of a connection for reading, with one consistent view.
        writing: options of a connection for writing.
    """

    reading: Mapping[str, Any]
    writing: Mapping[str, Any]

    def engine(self, url: str) -> AsyncEngine:
        """An engine whose connections are ready to use. Opens nothing yet.

        Raises:
            ArgumentError: it is no valid URL.
        """
        ...

    async def knock(self, engine: AsyncEngine) -> None:
        """Check that the database is there, where a failed attempt of the driver would leak something."""
        ...

    async def take_turn(self, connection: AsyncConnection) -> None:
        """Wait, at the beginning of a transaction, until no other process writes.

        So no query needs to handle a second writer, and rows are numbered in the order in which they become visible.
        """
        ...

    async def do(self, writer: AsyncEngine, work: Callable[[Connection], T]) -> T:
        """Run one writing transaction, with the wait; `work` may be called in another thread."""
        ...

    async def at_once(self, writer: AsyncEngine, make: Callable[[], AtOnce[T] | None]) -> T | None:
        """Run one writing transaction by one message, where that is cheaper than `do`; None when it wrote nothing.

        It writes nothing when one of its new rows exists already.
        """
        ...

    async def close(self, engine: AsyncEngine) -> None:
        """Close the engine's connections and other resources; harmless when repeated."""
        ...

    def is_away(self, error: Exception) -> bool:
        """Whether the database is unavailable, as opposed to an error in the request."""
        ...

    def remedy(self, reason: str) -> str:
        """The remedy for a database that could not be opened."""
        ...


def insert_new(connection: AsyncConnection, table: Table) -> Insert:
    """An INSERT that skips rows whose key exists already."""
    if connection.dialect.name == "postgresql":
        return postgresql.insert(table).on_conflict_do_nothing()
    return sqlite.insert(table).on_conflict_do_nothing()
