"""Samples of the factory's figures in SQL, one per wall minute."""

from __future__ import annotations

import msgspec
from sqlalchemy import delete, insert, select
from sqlalchemy.ext.asyncio import AsyncConnection

from dray.store.tables import kpi_samples


class KpiSample(msgspec.Struct, frozen=True, kw_only=True, gc=False):
    """What one wall minute, or part of it, has added. Times in it are factory seconds, ways metres.

    Only sums are kept, so that longer spans add up exactly; but for the quantiles, which are as they were
    at its end.
    """

    at_s: float
    """Its end, wall clock."""
    span_s: float
    """Its length."""
    orders_delivered: int
    orders_on_time: int
    transports: int
    """Handed over."""
    transport_p50_s: float | None
    """Over the last 200 transports, as it was at the end; None before the first one."""
    transport_p95_s: float | None
    empty_m: float
    loaded_m: float
    commands: int
    """People's commands that vehicles have obeyed."""
    helps: int
    """How often a vehicle has asked for help."""
    atv_moving_s: float
    atv_waiting_s: float
    atv_charging_s: float
    atv_blocked_s: float
    atv_idle_s: float
    atv_silent_s: float
    machine_making_s: float
    machine_starved_s: float
    machine_idle_s: float
    machine_broken_s: float
    """In error, with a goal."""
    machine_down_s: float
    """In error, without one."""
    machine_silent_s: float
    atv_out_of_service_s: float = 0.0
    """By a person's word; no part of the fleet's time otherwise."""
    energy_wh: float = 0.0
    """Taken from vehicles' batteries, by what these show."""
    machine_resting_s: float = 0.0
    """By their working time; no part of the machines' time otherwise."""


class Kpis:
    """The samples, inside one transaction."""

    def __init__(self, connection: AsyncConnection) -> None:
        self._connection = connection

    async def add(self, sample: KpiSample) -> None:
        """Keep a sample."""
        await self._connection.execute(insert(kpi_samples), [msgspec.structs.asdict(sample)])

    async def between(self, since_s: float, until_s: float) -> list[KpiSample]:
        """Samples that end after `since_s` and not after `until_s`, oldest first."""
        columns = [kpi_samples.c[name] for name in KpiSample.__struct_fields__]
        query = (
            select(*columns)
            .where(kpi_samples.c.at_s > since_s, kpi_samples.c.at_s <= until_s)
            .order_by(kpi_samples.c.at_s, kpi_samples.c.position)
        )
        rows = await self._connection.execute(query)
        return [KpiSample(**row._mapping) for row in rows]  # noqa: SLF001 - SQLAlchemy's public name

    async def newest_at_s(self) -> float | None:
        """The end of the sample that was added last, by whatever gateway; None before the first one."""
        newest = select(kpi_samples.c.at_s).order_by(kpi_samples.c.position.desc()).limit(1)
        return (await self._connection.execute(newest)).scalar()

    async def prune(self, before_s: float, at_most: int) -> int:
        """Forget some samples from before this moment; returns how many."""
        c = kpi_samples.c
        old = select(c.position).where(c.at_s < before_s).limit(at_most)
        return (await self._connection.execute(delete(kpi_samples).where(c.position.in_(old)))).rowcount
