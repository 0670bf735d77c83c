"""Samples of the factory's figures in SQL, one per wall minute."""

from __future__ import annotations

import msgspec
from sqlalchemy import delete, insert, select
from sqlalchemy.ext.asyncio import AsyncConnection

from dray.store.tables import kpi_samples


class KpiSample(msgspec.Struct, frozen=True, kw_only=True, gc=False):
    """The sums of one wall minute, or part of it. Times in it are factory seconds, distances metres.

    Only sums are stored, so that longer times add up exactly; the exceptions are the quantiles, which are those at its
    end.
    """

    at_s: float
    """Its end, wall clock."""
    span_s: float
    """Its length."""
    orders_delivered: int
    orders_on_time: int
    transports: int
    """Transports handed over."""
    transport_p50_s: float | None
    """The median of the last 200 transports, at the end; None before the first one."""
    transport_p95_s: float | None
    empty_m: float
    loaded_m: float
    commands: int
    """People's commands that vehicles have obeyed."""
    helps: int
    """Number of vehicles' calls for help."""
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
    """Time in error, with a goal."""
    machine_down_s: float
    """Time in error, without one."""
    machine_silent_s: float
    atv_out_of_service_s: float = 0.0
    """Time out of service by a person's command; not part of the fleet's other times."""
    energy_wh: float = 0.0
    """Energy taken from vehicles' batteries, by their reports."""
    machine_resting_s: float = 0.0
    """Time outside working hours; not part of the machines' other times."""


class Kpis:
    """The samples, inside one transaction."""

    def __init__(self, connection: AsyncConnection) -> None:
        self._connection = connection

    async def add(self, sample: KpiSample) -> None:
        """Store a sample."""
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
        """The end of the newest sample, of any gateway; None before the first one."""
        newest = select(kpi_samples.c.at_s).order_by(kpi_samples.c.position.desc()).limit(1)
        return (await self._connection.execute(newest)).scalar()

    async def prune(self, before_s: float, at_most: int) -> int:
        """Delete some samples from before this moment; returns the number."""
        c = kpi_samples.c
        old = select(c.position).where(c.at_s < before_s).limit(at_most)
        return (await self._connection.execute(delete(kpi_samples).where(c.position.in_(old)))).rowcount
