"""Incarnations in SQL: a number that grows with every start of a plant's agents."""

from __future__ import annotations

from sqlalchemy import select, update
from sqlalchemy.ext.asyncio import AsyncConnection

from dray.store.dialect import insert_new
from dray.store.tables import incarnations


class Incarnations:
    """The counters, inside one transaction."""

    def __init__(self, connection: AsyncConnection) -> None:
        self._connection = connection

    async def next(self, plant: str) -> int:
        """A number greater than all that were given for this plant before; the first is 1."""
        await self._connection.execute(
            insert_new(self._connection, incarnations), [{"plant": plant, "incarnation": 0}]
        )
        mine = incarnations.c.plant == plant
        await self._connection.execute(
            update(incarnations).where(mine).values(incarnation=incarnations.c.incarnation + 1)
        )
        query = select(incarnations.c.incarnation).where(mine)
        return int((await self._connection.execute(query)).scalar_one())
