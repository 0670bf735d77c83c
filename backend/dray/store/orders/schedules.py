"""Schedules in SQL: what is to be brought or made again and again, and which moment of its calendar comes next.

A row moves on from one moment to the next in the transaction in which that moment's work is placed, and only if nobody else has moved it
since it was read: so a moment is used once, however many gateways there are and whenever one of them dies.
"""

from __future__ import annotations

from collections.abc import Iterable

import msgspec
from sqlalchemy import (
    Boolean,
    Column,
    Double,
    Index,
    Integer,
    String,
    Table,
    Text,
    UniqueConstraint,
    and_,
    delete,
    exists,
    func,
    insert,
    literal,
    or_,
    select,
    update,
)
from sqlalchemy.exc import IntegrityError
from sqlalchemy.ext.asyncio import AsyncConnection

from dray.store.tables import Id, api_keys, metadata, people

schedules = Table(
    "schedules",
    metadata,
    Column("id", Id, primary_key=True),
    Column("name", String(80), nullable=False),
    Column("calendar", String(120), nullable=False),
    Column("time_zone", String(64), nullable=False),
    Column("holidays", Text, nullable=False),
    Column("make_up", Boolean, nullable=False),
    Column("paused", Boolean, nullable=False),
    Column("transport", Text, nullable=False),
    Column("order_draft", Text, nullable=False, server_default=""),
    Column("revision", Integer, nullable=False),
    Column("by", String(200), nullable=False),
    Column("at_s", Double, nullable=False),
    Column("next_at_s", Double),
    Column("last_at_s", Double),
    Column("last_transport", Id, nullable=False, server_default=""),
    Column("last_order", Id, nullable=False, server_default=""),
    Column("last_refused", Text, nullable=False, server_default=""),
    Column("missed_at_s", Double),
    Column("owner", String(200), nullable=False, server_default=""),
    Column("skipped", Text, nullable=False, server_default="[]"),
    UniqueConstraint("name"),
    Index(None, "next_at_s"),
    comment="Recurring work. next_at_s: the first moment of its calendar that is not used yet.",
)


class ScheduleRow(msgspec.Struct, frozen=True, kw_only=True, gc=False):
    """Something that recurs. Times are wall clock seconds."""

    id: str
    name: str
    """For people; no two have the same."""
    calendar: str
    """A cron expression."""
    time_zone: str
    holidays: str
    """JSON: a list of ISO dates."""
    make_up: bool
    """Whether the last moment that was missed is made up for."""
    paused: bool
    transport: str
    """JSON: what is to be brought, as `POST /api/transports` takes it; empty where an order is placed."""
    order_draft: str = ""
    """JSON: the order that is placed; empty where something is brought. One of both is empty."""
    revision: int
    """Grows with what people change."""
    by: str
    """The name of who has changed it last."""
    at_s: float
    """When."""
    next_at_s: float | None
    """The first moment of its calendar that is not used yet; None while it is paused, and when there is none any more."""
    last_at_s: float | None = None
    """The last moment that was used..."""
    last_transport: str = ""
    """...and which transport came of it; empty for none..."""
    last_order: str = ""
    """...or which order..."""
    last_refused: str = ""
    """...and why none came."""
    missed_at_s: float | None = None
    """The last moment that was left out because it was past."""
    owner: str = ""
    """Kind and id of who has begun it, or has changed what it asks for since; empty where nobody knows."""
    skipped: str = "[]"
    """JSON: a list of moments of its calendar at which nothing is done."""


_COLUMNS = [schedules.c[name] for name in ScheduleRow.__struct_fields__]


class Schedules:
    """The schedules, inside one transaction."""

    def __init__(self, connection: AsyncConnection) -> None:
        self._connection = connection

    async def all(self) -> list[ScheduleRow]:
        """Every one, by id."""
        rows = await self._connection.execute(select(*_COLUMNS).order_by(schedules.c.id))
        return [_row(row) for row in rows]

    async def due(self, now_s: float) -> list[ScheduleRow]:
        """Those whose next moment has come, the longest waiting first."""
        c = schedules.c
        query = select(*_COLUMNS).where(c.next_at_s <= now_s).order_by(c.next_at_s, c.id)
        return [_row(row) for row in await self._connection.execute(query)]

    async def owners_gone(self, now_s: float) -> frozenset[str]:
        """Owners who may do nothing any more: keys that were taken back or have run out, and people who may not log in."""
        owner, key = schedules.c.owner, api_keys.c
        has_key = exists().where(
            literal("key ") + key.id == owner,
            key.revoked_at_s.is_(None),
            or_(key.expires_at_s.is_(None), key.expires_at_s > now_s),
        )
        may_log_in = exists().where(
            literal("person ") + people.c.id == owner, people.c.disabled_at_s.is_(None)
        )
        gone = or_(and_(owner.startswith("key "), ~has_key), and_(owner.startswith("person "), ~may_log_in))
        return frozenset((await self._connection.execute(select(owner).distinct().where(gone))).scalars())

    async def next_s(self) -> float | None:
        """When the next moment of any of them is."""
        found: float | None = (
            await self._connection.execute(select(func.min(schedules.c.next_at_s)))
        ).scalar()
        return found

    async def get(self, schedule: str) -> ScheduleRow | None:
        """One, or None."""
        rows = await self._connection.execute(select(*_COLUMNS).where(schedules.c.id == schedule))
        return next((_row(row) for row in rows), None)

    async def named(self, name: str) -> ScheduleRow | None:
        """The one of this name, or None."""
        rows = await self._connection.execute(select(*_COLUMNS).where(schedules.c.name == name))
        return next((_row(row) for row in rows), None)

    async def add(self, row: ScheduleRow) -> bool:
        """Keep a new one; False when its name has just been taken: the transaction is over then."""
        try:
            await self._connection.execute(insert(schedules), [msgspec.structs.asdict(row)])
        except IntegrityError:
            return False
        return True

    async def change(self, before: ScheduleRow, after: ScheduleRow) -> bool:
        """Replace one; False when it is not as it was read, or the new name is taken (the transaction is over then)."""
        c, values = schedules.c, msgspec.structs.asdict(after)
        unchanged = c.next_at_s.is_not_distinct_from(before.next_at_s)
        query = update(schedules).where(c.id == values.pop("id"), c.revision == before.revision, unchanged)
        try:
            return (await self._connection.execute(query.values(**values))).rowcount == 1
        except IntegrityError:
            return False

    async def remove(self, row: ScheduleRow) -> bool:
        """Forget one; False when it is not of this revision any more."""
        c = schedules.c
        query = delete(schedules).where(c.id == row.id, c.revision == row.revision)
        return (await self._connection.execute(query)).rowcount == 1


def _row(values: Iterable[object]) -> ScheduleRow:
    return msgspec.convert(dict(zip(ScheduleRow.__struct_fields__, values, strict=True)), ScheduleRow)
