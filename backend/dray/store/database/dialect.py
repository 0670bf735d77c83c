"""What SQLite and PostgreSQL want done differently; `sqlite` and `postgresql` do it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Generic, Protocol, TypeVar

import msgspec
from sqlalchemy import Connection, Insert, Table
from sqlalchemy.dialects import postgresql, sqlite
from sqlalchemy.ext.asyncio import AsyncConnection, AsyncEngine

T = TypeVar("T")

BUSY_TIMEOUT_MS = 5_000
"""How long to wait for another process's write: an upgrade or a backup takes seconds, no more."""


class AtOnce(msgspec.Struct, Generic[T], frozen=True):
    """A writing transaction that is one statement, which takes its turn itself."""

    statement: str
    """As the driver takes it; its only value tells whether anything was written."""
    arguments: tuple[object, ...]
    done: T
    """What is told when it was."""


class Dialect(Protocol):
    """One kind of database.

    Attributes:
        reading: options of a connection that only reads, and sees one moment of the database.
        writing: options of a connection that writes.
    """

    reading: Mapping[str, Any]
    writing: Mapping[str, Any]

    def engine(self, url: str) -> AsyncEngine:
        """An engine whose connections are ready to use. Opens nothing yet.

        Raises:
            ArgumentError: it cannot be read as a URL.
        """
        ...

    async def knock(self, engine: AsyncEngine) -> None:
        """Try whether anything is there, when a failed attempt of the driver would leave something behind."""
        ...

    async def take_turn(self, connection: AsyncConnection) -> None:
        """Wait, at the beginning of a transaction, until no other process writes.

        So no query has to reckon with a second writer, and rows are numbered in the order in which they
        become visible.
        """
        ...

    async def do(self, writer: AsyncEngine, work: Callable[[Connection], T]) -> T:
        """One writing transaction, turn and all; `work` may be called in another thread."""
        ...

    async def at_once(self, writer: AsyncEngine, make: Callable[[], AtOnce[T] | None]) -> T | None:
        """One writing transaction by one message, where that is less than `do`; None when nothing was written.

        It writes nothing when a row that it adds is there already.
        """
        ...

    async def close(self, engine: AsyncEngine) -> None:
        """Close the engine's connections and what was opened beside it; harmless when done twice."""
        ...

    def is_away(self, error: Exception) -> bool:
        """Whether it is the database that cannot be used at present, and not what was asked of it."""
        ...

    def remedy(self, reason: str) -> str:
        """What to do about a database that could not be opened."""
        ...


def insert_new(connection: AsyncConnection, table: Table) -> Insert:
    """An INSERT that skips rows whose key is there already."""
    if connection.dialect.name == "postgresql":
        return postgresql.insert(table).on_conflict_do_nothing()
    return sqlite.insert(table).on_conflict_do_nothing()
