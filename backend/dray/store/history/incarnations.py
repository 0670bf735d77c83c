"""Incarnations in SQL: a number that grows with every start of a plant's agents.

Between two starts of a plant its agents may be restarted one by one, and increment the number by themselves. Names of tasks and
goals, and keys of events, contain these numbers. So a start continues after the highest known one.
"""

from __future__ import annotations

from sqlalchemy import func, select, update
from sqlalchemy.ext.asyncio import AsyncConnection

from dray.store.database.dialect import insert_new
from dray.store.tables import events, goals, incarnations, orders


class Incarnations:
    """The counters, inside one transaction."""

    def __init__(self, connection: AsyncConnection) -> None:
        self._connection = connection

    async def next(self, plant: str) -> int:
        """A number greater than all that were given for this plant, or used, before; the first is 1."""
        await self._connection.execute(
            insert_new(self._connection, incarnations), [{"plant": plant, "incarnation": 0}]
        )
        mine = incarnations.c.plant == plant
        highest = 0
        for query in (
            select(incarnations.c.incarnation).where(mine),
            # One database serves one plant at a time; with two, skipping numbers does no harm.
            select(func.max(events.c.incarnation)),
            select(func.max(goals.c.incarnation)),
            select(func.max(orders.c.incarnation)),
        ):
            highest = max(highest, (await self._connection.execute(query)).scalar() or 0)
        await self._connection.execute(update(incarnations).where(mine).values(incarnation=highest + 1))
        return highest + 1
