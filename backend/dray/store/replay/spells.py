"""Spells in SQL: the activities of every vehicle and machine, with their times."""

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
"""Maximum spans per query: SQLite's parser allows expressions up to a depth of 1,000."""

MOST_OF_SPANS = 20_000
"""Maximum spells read for them: some minutes of each transport, for vehicles that alternate between waiting and driving."""


class Spell(msgspec.Struct, frozen=True, kw_only=True, gc=False):
    """One uninterrupted activity of one agent. Times are wall clock."""

    agent: str
    doing: AtvDoing | MachineDoing
    from_at_s: float
    until_at_s: float
    task: str = ""
    item: str = ""
    """The item carried or made."""
    source: str = ""
    destination: str = ""
    other: str = ""
    """What or whom it waited for, or its problem."""


class Spells:
    """The spells, inside one transaction."""

    def __init__(self, connection: AsyncConnection) -> None:
        self._connection = connection

    async def add(self, new: Sequence[Spell]) -> None:
        """Store spells."""
        if new:
            await self._connection.execute(insert(spells), [msgspec.structs.asdict(each) for each in new])

    async def between(self, since_s: float, until_s: float, agents: Sequence[str], limit: int) -> list[Spell]:
        """The spells of a time, also in part, by their ends.

        Args:
            since_s: spells that ended earlier are left out.
            until_s: spells that began later are left out.
            agents: the agents; empty for all.
            limit: maximum number of spells.
        """
        columns = [spells.c[name] for name in Spell.__struct_fields__]
        query = select(*columns).where(spells.c.until_at_s > since_s, spells.c.from_at_s < until_s)
        if agents:
            query = query.where(spells.c.agent.in_(agents))
        rows = await self._connection.execute(query.order_by(spells.c.until_at_s).limit(limit))
        return [Spell(**row._mapping) for row in rows]  # noqa: SLF001 - SQLAlchemy's public name

    async def of_spans(self, spans: Sequence[tuple[str, float, float]], doings: Sequence[str]) -> list[Spell]:
        """The spells of agents within their own spans, also in part, by their ends.

        Args:
            spans: agents, each with a beginning and an end (wall clock).
            doings: the wanted activities.
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
        """Delete some of the oldest that ended before this moment; returns the number."""
        c = spells.c
        old = select(c.position).where(c.until_at_s < before_s).order_by(c.until_at_s).limit(at_most)
        return (await self._connection.execute(delete(spells).where(c.position.in_(old)))).rowcount
