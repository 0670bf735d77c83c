"""The changes of an order's delivery estimate in SQL, each with its cause. Stored as long as the order.

A row is written when an estimate has moved by more than its rounding step, so there are few. Above the maximum the
second and later ones are deleted first; the first one shows the beginning.
"""

from __future__ import annotations

from typing import Literal

import msgspec
from sqlalchemy import Column, Double, ForeignKey, String, Table, delete, insert, select
from sqlalchemy.ext.asyncio import AsyncConnection

from dray.store.tables import Id, metadata

ESTIMATES_MOST = 60
"""Maximum estimates per order."""

EstimateCause = Literal[
    "first",
    "changed",
    "moved",
    "stands",
    "silent",
    "material",
    "passed",
    "replaced",
    "held_up",
    "no_machine",
    "later",
    "sooner",
    "closer",
    "again",
    "unknown",
]
"""`changed`: people have changed the order. `moved`: a part of it continues at another machine. `stands`, `silent`, `material`: about a
machine that makes it. `passed`: another order now comes first. `replaced`: another vehicle continues. `held_up`: its goods are delayed.
`no_machine`: no machine can make a part. `later`, `sooner`: production or transport differs from the plan. `closer`: the same, more
exactly. `again`: an estimate is possible again. `unknown`: it is not possible any more."""

order_estimates = Table(
    "order_estimates",
    metadata,
    Column("order_id", Id, ForeignKey("orders.id", ondelete="CASCADE"), primary_key=True),
    Column("at_s", Double, primary_key=True),
    Column("from_at_s", Double),
    Column("to_at_s", Double),
    Column("cause", String(16), nullable=False),
    Column("agent", Id, nullable=False),
    Column("other", Id, nullable=False),
    comment="How the estimates of orders have moved, and why; without from_at_s and to_at_s where nothing could be told.",
)


class Estimate(msgspec.Struct, frozen=True, kw_only=True, gc=False):
    """An order's estimate from a moment on. Times are wall clock seconds."""

    at_s: float
    from_at_s: float | None
    """The earliest expected time; None without an estimate."""
    to_at_s: float | None
    cause: EstimateCause
    agent: str = ""
    """The machine or vehicle concerned; for `replaced` and `moved` the previous one."""
    other: str = ""
    """For `replaced` and `moved` the next agent, for `material` the missing material, for `passed` the other order."""


_COLUMNS = [order_estimates.c[name] for name in Estimate.__struct_fields__]


class Estimates:
    """The estimates of orders, inside one transaction."""

    def __init__(self, connection: AsyncConnection) -> None:
        self._connection = connection

    async def of_order(self, order_id: str) -> list[Estimate]:
        """An order's estimates, oldest first."""
        c = order_estimates.c
        query = select(*_COLUMNS).where(c.order_id == order_id).order_by(c.at_s)
        return [Estimate(**row._mapping) for row in await self._connection.execute(query)]  # noqa: SLF001 - SQLAlchemy's public name

    async def newest(self, order_id: str) -> Estimate | None:
        """The last one of an order, or None."""
        c = order_estimates.c
        query = select(*_COLUMNS).where(c.order_id == order_id).order_by(c.at_s.desc()).limit(1)
        row = (await self._connection.execute(query)).first()
        return None if row is None else Estimate(**row._mapping)  # noqa: SLF001 - SQLAlchemy's public name

    async def add(self, order_id: str, estimate: Estimate) -> None:
        """Store a newer estimate of its order."""
        c = order_estimates.c
        known = select(c.at_s).where(c.order_id == order_id).order_by(c.at_s)
        times = list((await self._connection.execute(known)).scalars())
        gone = times[1 : len(times) - ESTIMATES_MOST + 2]
        if len(times) >= ESTIMATES_MOST:
            await self._connection.execute(
                delete(order_estimates).where(c.order_id == order_id, c.at_s.in_(gone))
            )
        row = {"order_id": order_id} | msgspec.structs.asdict(estimate)
        await self._connection.execute(insert(order_estimates), [row])
