"""Schedules in SQL: recurring transports and orders, and the next moment of each calendar.

A row advances to its next moment in the transaction that places the present moment's work. It must be unchanged since it was read.
So each moment is used once, with any number of gateways and even if one of them dies.
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
    Column("holidays_of", String(64), nullable=False, server_default=""),
    Column("made_up_at_s", Double),
    UniqueConstraint("name"),
    Index(None, "next_at_s"),
    comment="Recurring work. next_at_s: the first moment of its calendar that is not used yet.",
)


class ScheduleRow(msgspec.Struct, frozen=True, kw_only=True, gc=False):
    """A recurring transport or order. Times are wall clock seconds."""

    id: str
    name: str
    """A unique name for people."""
    calendar: str
    """A cron expression."""
    time_zone: str
    holidays: str
    """JSON: a list of ISO dates."""
    make_up: bool
    """Whether the last missed moment is made up for."""
    paused: bool
    transport: str
    """JSON: the transport, as for `POST /api/transports`; empty for an order."""
    order_draft: str = ""
    """JSON: the order; empty for a transport. Exactly one of both is set."""
    revision: int
    """The revision, which grows with people's changes."""
    by: str
    """The name of the author of the last change."""
    at_s: float
    """The time of the last change."""
    next_at_s: float | None
    """The next unused moment of its calendar; None while it is paused, or without further moments."""
    last_at_s: float | None = None
    """The last used moment."""
    last_transport: str = ""
    """The transport of that moment; empty for none."""
    last_order: str = ""
    """The order of that moment; empty for none."""
    last_refused: str = ""
    """The refusal at that moment; empty for none."""
    missed_at_s: float | None = None
    """The last skipped moment that was past."""
    owner: str = ""
    """Kind and id of its creator, or of the last author of its content; empty if unknown."""
    skipped: str = "[]"
    """JSON: the skipped moments of its calendar."""
    holidays_of: str = ""
    """A country or region whose public holidays are left out, as `DE-BW`; empty for none."""
    made_up_at_s: float | None = None
    """When the last used moment was made up for after an absence; None if it was in time."""


_COLUMNS = [schedules.c[name] for name in ScheduleRow.__struct_fields__]


class Schedules:
    """The schedules, inside one transaction."""

    def __init__(self, connection: AsyncConnection) -> None:
        self._connection = connection

    async def all(self) -> list[ScheduleRow]:
        """All schedules, by id."""
        rows = await self._connection.execute(select(*_COLUMNS).order_by(schedules.c.id))
        return [_row(row) for row in rows]

    async def contents(self) -> list[tuple[str, str, str]]:
        """Of all schedules the name, and its transport and order as JSON, one of which is empty."""
        c = schedules.c
        rows = await self._connection.execute(select(c.name, c.transport, c.order_draft))
        return [(name, transport, order) for name, transport, order in rows]

    async def due(self, now_s: float) -> list[ScheduleRow]:
        """The schedules whose next moment has come, the longest waiting first."""
        c = schedules.c
        query = select(*_COLUMNS).where(c.next_at_s <= now_s).order_by(c.next_at_s, c.id)
        return [_row(row) for row in await self._connection.execute(query)]

    async def owners_gone(self, now_s: float) -> frozenset[str]:
        """Owners without permissions: revoked or expired keys, and people who may not log in."""
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
        """The next moment of any of them."""
        found: float | None = (
            await self._connection.execute(select(func.min(schedules.c.next_at_s)))
        ).scalar()
        return found

    async def get(self, schedule: str) -> ScheduleRow | None:
        """A schedule, or None."""
        rows = await self._connection.execute(select(*_COLUMNS).where(schedules.c.id == schedule))
        return next((_row(row) for row in rows), None)

    async def named(self, name: str) -> ScheduleRow | None:
        """The schedule with this name, or None."""
        rows = await self._connection.execute(select(*_COLUMNS).where(schedules.c.name == name))
        return next((_row(row) for row in rows), None)

    async def add(self, row: ScheduleRow) -> bool:
        """Store a new one; False when its name is taken: then the transaction is over."""
        try:
            await self._connection.execute(insert(schedules), [msgspec.structs.asdict(row)])
        except IntegrityError:
            return False
        return True

    async def change(self, before: ScheduleRow, after: ScheduleRow) -> bool:
        """Replace one; False when it has changed since it was read, or the new name is taken (then the transaction is over)."""
        c, values = schedules.c, msgspec.structs.asdict(after)
        unchanged = c.next_at_s.is_not_distinct_from(before.next_at_s)
        query = update(schedules).where(c.id == values.pop("id"), c.revision == before.revision, unchanged)
        try:
            return (await self._connection.execute(query.values(**values))).rowcount == 1
        except IntegrityError:
            return False

    async def remove(self, row: ScheduleRow) -> bool:
        """Delete one; False when its revision has changed."""
        c = schedules.c
        query = delete(schedules).where(c.id == row.id, c.revision == row.revision)
        return (await self._connection.execute(query)).rowcount == 1


def _row(values: Iterable[object]) -> ScheduleRow:
    return msgspec.convert(dict(zip(ScheduleRow.__struct_fields__, values, strict=True)), ScheduleRow)
