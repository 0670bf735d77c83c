"""Spells in SQL: what every vehicle and machine did, from when to when."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import msgspec
from sqlalchemy import and_, delete, insert, or_, select
from sqlalchemy.ext.asyncio import AsyncConnection

from dray.store.replay.tables import spells

AtvDoing = Literal["fetches", "carries", "waits", "charges", "idle", "stopped", "blocked", "out", "silent"]

MachineDoing = Literal["makes", "starves", "idle", "rests", "blocked", "broken", "out", "silent"]


SPANS_AT_ONCE = 100
"""Of one question: SQLite's parser takes no deeper expression than 1,000."""

MOST_OF_SPANS = 20_000
"""Spells that are read for them: some minutes of each transport, of whoever waits and drives by turns."""


class Spell(msgspec.Struct, frozen=True, kw_only=True, gc=False):
    """What one agent did without a break. Times are wall clock."""

    agent: str
    doing: AtvDoing | MachineDoing
    from_at_s: float
    until_at_s: float
    task: str = ""
    item: str = ""
    """What it carried or made."""
    source: str = ""
    destination: str = ""
    other: str = ""
    """For whom or for what it waited, or what was wrong."""


class Spells:
    """The spells, inside one transaction."""

    def __init__(self, connection: AsyncConnection) -> None:
        self._connection = connection

    async def add(self, new: Sequence[Spell]) -> None:
        """Keep these."""
        if new:
            await self._connection.execute(insert(spells), [msgspec.structs.asdict(each) for each in new])

    async def between(self, since_s: float, until_s: float, agents: Sequence[str], limit: int) -> list[Spell]:
        """Those of a time, also in part, in the order in which they ended.

        Args:
            since_s: what ended before it is left out.
            until_s: what began after it is left out.
            agents: whose; empty for all.
            limit: how many at most.
        """
        columns = [spells.c[name] for name in Spell.__struct_fields__]
        query = select(*columns).where(spells.c.until_at_s > since_s, spells.c.from_at_s < until_s)
        if agents:
            query = query.where(spells.c.agent.in_(agents))
        rows = await self._connection.execute(query.order_by(spells.c.until_at_s).limit(limit))
        return [Spell(**row._mapping) for row in rows]  # noqa: SLF001 - SQLAlchemy's public name

    async def of_spans(self, spans: Sequence[tuple[str, float, float]], doings: Sequence[str]) -> list[Spell]:
        """What agents did in times of their own, also in part, in the order in which they ended.

        Args:
            spans: agents, each since when and until when (wall clock).
            doings: what of it is wanted.
        """
        c = spells.c
        columns = [c[name] for name in Spell.__struct_fields__]
        found: list[Spell] = []
        for start in range(0, len(spans), SPANS_AT_ONCE):
            some = [
                and_(c.agent == agent, c.until_at_s > since_s, c.from_at_s < until_s)
                for agent, since_s, until_s in spans[start : start + SPANS_AT_ONCE]
            ]
            query = select(*columns).where(c.doing.in_(doings), or_(*some)).order_by(c.until_at_s)
            rows = await self._connection.execute(query.limit(MOST_OF_SPANS))
            found += [Spell(**row._mapping) for row in rows]  # noqa: SLF001 - SQLAlchemy's public name
        return found

    async def prune(self, before_s: float, at_most: int) -> int:
        """Forget some of the oldest that ended before this moment; returns how many."""
        c = spells.c
        old = select(c.position).where(c.until_at_s < before_s).order_by(c.until_at_s).limit(at_most)
        return (await self._connection.execute(delete(spells).where(c.position.in_(old)))).rowcount
