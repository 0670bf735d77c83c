"""The extent of stored history: the oldest of each kind. `retention` defines the deletion."""

from __future__ import annotations

from collections.abc import Callable

import msgspec
from sqlalchemy import Column, ColumnElement, func, select
from sqlalchemy.ext.asyncio import AsyncConnection

from dray.store.factory.alert_history import alerts
from dray.store.factory.lane_traffic import lane_traffic
from dray.store.orders.tasks import tasks
from dray.store.orders.transports import transports
from dray.store.replay.tables import recordings
from dray.store.tables import audit, events, heartbeat_samples, kpi_samples, orders


class Oldest(msgspec.Struct, frozen=True, kw_only=True, gc=False):
    """The time of the oldest of each kind, in wall seconds since 1970; None where there is none."""

    orders_s: float | None
    events_s: float | None
    replay_s: float | None
    samples_s: float | None
    figures_s: float | None
    lanes_s: float | None
    tasks_s: float | None
    transports_s: float | None
    alerts_s: float | None
    audit_s: float | None
    events: int
    """Rows of the event log."""


class Kept:
    """The oldest of each kind, inside one transaction. Each look-up uses an index, so its cost does not depend on the size."""

    def __init__(self, connection: AsyncConnection) -> None:
        self._connection = connection

    async def oldest(self) -> Oldest:
        """The oldest of each kind."""
        first, last = await self._position(func.min), await self._position(func.max)
        return Oldest(
            orders_s=await self._first(orders.c.created_at_s),
            events_s=await self._at_first(events.c.position, events.c.at_s),
            replay_s=await self._first(recordings.c.from_at_s),
            samples_s=await self._at_first(heartbeat_samples.c.position, heartbeat_samples.c.at_s),
            figures_s=await self._first(kpi_samples.c.at_s),
            lanes_s=await self._first(lane_traffic.c.hour_s),
            tasks_s=await self._first(tasks.c.opened_at_s),
            transports_s=await self._first(transports.c.created_at_s),
            alerts_s=await self._first(alerts.c.since_at_s),
            audit_s=await self._first(audit.c.at_s),
            events=last - first + 1 if last else 0,
        )

    async def _first(self, at: Column[float]) -> float | None:
        return (await self._connection.execute(select(func.min(at)))).scalar()

    async def _at_first(self, position: Column[int], at: Column[float]) -> float | None:
        """The time of the first stored row; with late events it may not be the oldest, by seconds."""
        return (await self._connection.execute(select(at).order_by(position).limit(1))).scalar()

    async def _position(self, which: Callable[[Column[int]], ColumnElement[int]]) -> int:
        return (await self._connection.execute(select(which(events.c.position)))).scalar() or 0
