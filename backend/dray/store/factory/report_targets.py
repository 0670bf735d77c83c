"""Target values of a shift's figures in SQL."""

from __future__ import annotations

import msgspec
from sqlalchemy import Column, Double, String, Table, delete, insert, select
from sqlalchemy.ext.asyncio import AsyncConnection

from dray.store.tables import metadata

report_targets = Table(
    "report_targets",
    metadata,
    Column("figure", String(32), primary_key=True),
    Column("value", Double, nullable=False),
    Column("by", String(80), nullable=False),
    Column("at_s", Double, nullable=False),
    comment="What figures of a shift should reach; a figure without a row has no target.",
)


class Target(msgspec.Struct, frozen=True, gc=False):
    """The target of one figure."""

    figure: str
    value: float
    by: str
    """The author's name."""
    at_s: float
    """The time of setting it; wall clock."""


class ReportTargets:
    """The targets, inside one transaction."""

    def __init__(self, connection: AsyncConnection) -> None:
        self._connection = connection

    async def all(self) -> list[Target]:
        """Every target, by figure."""
        columns = [report_targets.c[name] for name in Target.__struct_fields__]
        rows = await self._connection.execute(select(*columns).order_by(report_targets.c.figure))
        return [Target(*row) for row in rows]

    async def replace(self, targets: list[Target]) -> None:
        """Replace all targets by these."""
        await self._connection.execute(delete(report_targets))
        if targets:
            await self._connection.execute(
                insert(report_targets), [msgspec.structs.asdict(each) for each in targets]
            )
