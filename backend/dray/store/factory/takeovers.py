"""Takeovers of transports by other agents in SQL. They are a figure of shifts, and so stored as long as figures.

They are written in the transaction that stores their events, each once.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import msgspec
from sqlalchemy import Column, Double, Index, Integer, Table, Text, delete, func, select, tuple_
from sqlalchemy.ext.asyncio import AsyncConnection

from dray.messages import Event
from dray.messages.fact import CarrierChanged
from dray.store.database.dialect import insert_new
from dray.store.history.clocks import ToWall
from dray.store.tables import Id, events, metadata

takeovers = Table(
    "takeovers",
    metadata,
    Column("agent", Id, primary_key=True),
    Column("incarnation", Integer, primary_key=True, autoincrement=False),
    Column("number", Integer, primary_key=True, autoincrement=False),
    Column("at_s", Double, nullable=False),
    Column("fact", Text, nullable=False),
    Index(None, "at_s"),
    comment="When somebody else has gone on with a transport, by the event that tells of it; fact is JSON.",
)


class Takeover(msgspec.Struct, frozen=True, gc=False):
    """One takeover."""

    at_s: float
    """Wall clock."""
    fact: CarrierChanged


_READ = msgspec.json.Decoder(CarrierChanged)


class Takeovers:
    """The takeovers, inside one transaction. All times are wall clock."""

    def __init__(self, connection: AsyncConnection) -> None:
        self._connection = connection

    async def add(self, new: Iterable[Event], to_wall_s: ToWall) -> None:
        """Add the takeovers in these events; existing ones stay unchanged."""
        rows = [
            {
                "agent": event.agent,
                "incarnation": event.incarnation,
                "number": event.number,
                "at_s": to_wall_s(event.at_s),
                "fact": msgspec.json.encode(event.fact).decode(),
            }
            for event in new
            if isinstance(event.fact, CarrierChanged) and event.fact.carrier
        ]
        if rows:
            await self._connection.execute(insert_new(self._connection, takeovers), rows)

    async def between(self, since_s: float, until_s: float, limit: int) -> tuple[int, Sequence[Takeover]]:
        """The number of takeovers in a time, and the last of them, oldest first."""
        c = takeovers.c
        within = c.at_s >= since_s, c.at_s < until_s
        count = (await self._connection.execute(select(func.count()).where(*within))).scalar_one()
        query = select(c.at_s, c.fact).where(*within).limit(limit)
        rows = await self._connection.execute(query.order_by(c.at_s.desc(), c.agent, c.number.desc()))
        return count, [Takeover(row.at_s, _READ.decode(row.fact)) for row in rows][::-1]

    async def since_s(self) -> float | None:
        """The beginning of the known time: the oldest takeover, or the oldest event; None without any."""
        oldest_event = select(events.c.at_s).order_by(events.c.position).limit(1)
        known = [
            (await self._connection.execute(query)).scalar()
            for query in (select(func.min(takeovers.c.at_s)), oldest_event)
        ]
        return min((at_s for at_s in known if at_s is not None), default=None)

    async def prune(self, before_s: float, at_most: int) -> int:
        """Delete some from before this moment; returns the number."""
        key = tuple_(takeovers.c.agent, takeovers.c.incarnation, takeovers.c.number)
        old = select(*key.clauses).where(takeovers.c.at_s < before_s).limit(at_most)
        return (await self._connection.execute(delete(takeovers).where(key.in_(old)))).rowcount
