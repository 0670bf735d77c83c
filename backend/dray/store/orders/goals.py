"""Production goals in SQL."""

from __future__ import annotations

from collections.abc import Iterable

import msgspec
from sqlalchemy import ColumnElement, bindparam, select, update
from sqlalchemy.ext.asyncio import AsyncConnection

from dray.store.database.dialect import insert_new
from dray.store.orders.progress import Goal
from dray.store.tables import goals


class Goals:
    """The goals, inside one transaction."""

    def __init__(self, connection: AsyncConnection) -> None:
        self._connection = connection

    async def many(self, ids: Iterable[str]) -> dict[str, Goal]:
        """The goals with these ids, if they exist, by id."""
        return await self._select(goals.c.id.in_(list(ids)))

    async def of_orders(self, orders: Iterable[str]) -> dict[str, list[Goal]]:
        """The goals of each of these orders."""
        found: dict[str, list[Goal]] = {order: [] for order in orders}
        for goal in (await self._select(goals.c.order_id.in_(list(found)))).values():
            if goal.order_id is not None:
                found[goal.order_id].append(goal)
        return found

    async def put(self, changed: Iterable[Goal]) -> None:
        """Store goals, new or known."""
        rows = [msgspec.structs.asdict(goal) for goal in changed]
        if not rows:
            return
        await self._connection.execute(insert_new(self._connection, goals), rows)
        await self._connection.execute(
            update(goals).where(goals.c.id == bindparam("known")),
            [{("known" if name == "id" else name): value for name, value in row.items()} for row in rows],
        )

    async def end_open(self, at_s: float) -> None:
        """End all goals of which pieces have not arrived: their machines know them no more.

        Args:
            at_s: now (wall clock).
        """
        c = goals.c
        await self._connection.execute(
            update(goals)
            .where(c.incarnation > 0, c.machine != "", c.delivered < c.quantity)
            .values(machine="", quantity=0, promised_at_s=None, told_at_s=at_s)
        )

    async def _select(self, condition: ColumnElement[bool]) -> dict[str, Goal]:
        rows = await self._connection.execute(select(goals).where(condition))
        return {row.id: Goal(**row._mapping) for row in rows}  # noqa: SLF001 - SQLAlchemy's public name
