"""Sampled heartbeats in SQL: enough for reports about batteries, utilisation and ways."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import takewhile
from typing import Any

from sqlalchemy import delete, func, insert, select
from sqlalchemy.ext.asyncio import AsyncConnection

from dray.messages import AtvHeartbeat, Heartbeat
from dray.store.history import ages
from dray.store.history.clocks import ToWall
from dray.store.tables import heartbeat_samples


class Samples:
    """The samples, inside one transaction."""

    def __init__(self, connection: AsyncConnection) -> None:
        self._connection = connection

    async def add(self, heartbeats: Sequence[Heartbeat], to_wall_s: ToWall) -> None:
        """Store samples."""
        if heartbeats:
            rows = [_row(heartbeat, to_wall_s) for heartbeat in heartbeats]
            await self._connection.execute(insert(heartbeat_samples), rows)

    async def count(self) -> int:
        """The number of samples."""
        query = select(func.count()).select_from(heartbeat_samples)
        return (await self._connection.execute(query)).scalar_one()

    async def newest_s(self) -> float | None:
        """The sending time of the last written sample (wall clock); None before the first."""
        query = select(heartbeat_samples.c.at_s).order_by(heartbeat_samples.c.position.desc()).limit(1)
        found: float | None = (await self._connection.execute(query)).scalar_one_or_none()
        return found

    async def prune(self, before_s: float, at_most: int, now_s: float) -> int:
        """Delete some of the oldest, up to the first that is not from before this moment; returns the number."""
        aged = await ages.oldest(self._connection, heartbeat_samples, at_most, now_s)
        old = [position for position, _ in takewhile(lambda row: row[1] < before_s, aged)]
        if old:
            await self._connection.execute(
                delete(heartbeat_samples).where(heartbeat_samples.c.position <= old[-1])
            )
        return len(old)


def _row(heartbeat: Heartbeat, to_wall_s: ToWall) -> dict[str, Any]:
    common = {
        "at_s": to_wall_s(heartbeat.at_s),
        "plant_s": heartbeat.at_s,
        "status": heartbeat.status.value,
    }
    if isinstance(heartbeat, AtvHeartbeat):
        return common | {
            "agent": heartbeat.atv,
            "battery_frac": heartbeat.battery_frac,
            "x_m": heartbeat.pose.x_m,
            "y_m": heartbeat.pose.y_m,
        }
    return common | {"agent": heartbeat.machine, "battery_frac": None, "x_m": None, "y_m": None}
