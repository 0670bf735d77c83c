"""The change log in SQL: every change of an order or a plain transport, numbered in the order of the commits.

Triggers on both tables write it (`migrations/versions/0039_change_log.py`), so no change can be missed. The database has one writer
at a time, so a reader at a position has seen everything before it.
"""

from __future__ import annotations

import msgspec
from sqlalchemy import (
    Column,
    ColumnElement,
    Double,
    Index,
    String,
    Table,
    and_,
    delete,
    false,
    func,
    or_,
    select,
)
from sqlalchemy.ext.asyncio import AsyncConnection

from dray.store.orders.transports import TransportFilter, transports
from dray.store.tables import Id, Position, metadata, orders

change_log = Table(
    "change_log",
    metadata,
    Column("position", Position, primary_key=True, autoincrement=True),
    Column("kind", String(16), nullable=False),
    Column("subject", Id, nullable=False),
    Column("status", String(16), nullable=False),
    Column("at_s", Double, nullable=False),
    Index(None, "at_s"),
    # Numbers of deleted rows must never be reused: readers continue after the last one they saw.
    sqlite_autoincrement=True,
    comment="Every change of an order or a plain transport, in the order of the commits. Written by triggers.",
)

ORDER, TRANSPORT = "order", "transport"


class Change(msgspec.Struct, frozen=True, gc=False):
    """One change."""

    position: int
    """The change's number, in ascending order."""
    kind: str
    """ORDER or TRANSPORT."""
    subject: str
    """Its id."""
    status: str
    """The status after the change."""
    at_s: float
    """Wall clock."""
    reference: str | None
    """The customer's name of the order."""


class Seen(msgspec.Struct, frozen=True, kw_only=True):
    """The changes that a caller may see."""

    orders: bool
    """Whether orders are visible."""
    transports: TransportFilter | None
    """The visible transports; None for none."""

    def condition(self) -> ColumnElement[bool]:
        """The SQL condition; the table of transports is joined."""
        kind = change_log.c.kind
        shown = [kind == ORDER] if self.orders else []
        if self.transports is not None:
            shown.append(and_(kind == TRANSPORT, *self.transports.conditions()))
        return or_(false(), *shown)


class ChangeLog:
    """The change log, inside one transaction."""

    def __init__(self, connection: AsyncConnection) -> None:
        self._connection = connection

    async def ends(self) -> tuple[int, int]:
        """The positions of the oldest and of the newest stored change.

        A reader at the oldest position, or later, can continue. For this the log begins with a line that is no change, and keeps
        the newest of the deleted ones.
        """
        c = change_log.c
        oldest, newest = (
            await self._connection.execute(select(func.min(c.position), func.max(c.position)))
        ).one()
        return oldest or 0, newest or 0

    async def page(self, after: int, until: int, seen: Seen, limit: int) -> list[Change]:
        """Changes after a position and up to another one, oldest first.

        Args:
            after: the position of the last known change.
            until: the position of the last wanted change.
            seen: the visible changes.
            limit: maximum number of changes.
        """
        c = change_log.c
        query = (
            select(c.position, c.kind, c.subject, c.status, c.at_s, orders.c.reference)
            .select_from(
                change_log.outerjoin(orders, (c.kind == ORDER) & (orders.c.id == c.subject)).outerjoin(
                    transports, (c.kind == TRANSPORT) & (transports.c.id == c.subject)
                )
            )
            .where(c.position > after, c.position <= until, seen.condition())
            .order_by(c.position)
            .limit(limit)
        )
        return [Change(*row) for row in await self._connection.execute(query)]

    async def prune(self, before_s: float, at_most: int) -> int:
        """Delete some from before this moment, all but the newest of them; returns the number."""
        c = change_log.c
        oldest = select(c.position, c.at_s).order_by(c.position).limit(at_most + 1)
        rows = (await self._connection.execute(oldest)).all()
        old = 0
        while old < len(rows) and rows[old].at_s < before_s:
            old += 1
        if old < 2:
            return 0
        last = rows[old - 2].position
        await self._connection.execute(delete(change_log).where(c.position <= last))
        return old - 1
