"""The traffic of every lane in SQL, by wall hours."""

from __future__ import annotations

from collections.abc import Iterable

import msgspec
from sqlalchemy import Column, Double, Integer, Table, delete, func, insert, select
from sqlalchemy.ext.asyncio import AsyncConnection

from dray.store.tables import Id, metadata

lane_traffic = Table(
    "lane_traffic",
    metadata,
    Column("hour_s", Double, primary_key=True),
    Column("start_node", Id, primary_key=True),
    Column("end_node", Id, primary_key=True),
    Column("passes", Integer, nullable=False),
    Column("waits", Integer, nullable=False),
    Column("waited_s", Double, nullable=False),
    comment="What vehicles did on each lane in a wall hour; waited_s is in factory seconds.",
)


HOUR_S = 3600.0


class LaneTraffic(msgspec.Struct, frozen=True, gc=False):
    """The traffic on one lane, in its direction."""

    start: str
    end: str
    passes: int = 0
    """Number of passes."""
    waits: int = 0
    """Number of stops of vehicles on their way."""
    waited_s: float = 0.0
    """Total waiting time of vehicles on their way; factory seconds."""

    def __add__(self, other: LaneTraffic) -> LaneTraffic:
        return LaneTraffic(
            self.start,
            self.end,
            self.passes + other.passes,
            self.waits + other.waits,
            self.waited_s + other.waited_s,
        )


class LaneHours:
    """The lanes' hours, inside one transaction."""

    def __init__(self, connection: AsyncConnection) -> None:
        self._connection = connection

    async def add(self, at_s: float, lanes: Iterable[LaneTraffic]) -> None:
        """Add to the hour in which `at_s` lies (wall clock)."""
        hour_s = at_s // HOUR_S * HOUR_S
        more = {(lane.start, lane.end): lane for lane in lanes}
        if not more:
            return
        known = await self._connection.execute(select(lane_traffic).where(lane_traffic.c.hour_s == hour_s))
        for row in known:
            lane = LaneTraffic(row.start_node, row.end_node, row.passes, row.waits, row.waited_s)
            key = lane.start, lane.end
            more[key] = lane + more[key] if key in more else lane
        await self._connection.execute(delete(lane_traffic).where(lane_traffic.c.hour_s == hour_s))
        rows = [
            {
                "hour_s": hour_s,
                "start_node": lane.start,
                "end_node": lane.end,
                "passes": lane.passes,
                "waits": lane.waits,
                "waited_s": lane.waited_s,
            }
            for lane in more.values()
        ]
        await self._connection.execute(insert(lane_traffic), rows)

    async def between(self, since_s: float, until_s: float) -> list[LaneTraffic]:
        """The traffic per lane, in the hours that begin at `since_s` or later and before `until_s`."""
        columns = lane_traffic.c
        query = (
            select(
                columns.start_node,
                columns.end_node,
                func.sum(columns.passes),
                func.sum(columns.waits),
                func.sum(columns.waited_s),
            )
            .where(columns.hour_s >= since_s, columns.hour_s < until_s)
            .group_by(columns.start_node, columns.end_node)
            .order_by(columns.start_node, columns.end_node)
        )
        rows = await self._connection.execute(query)
        return [
            LaneTraffic(start, end, int(passes), int(waits), float(waited_s))
            for start, end, passes, waits, waited_s in rows
        ]

    async def forget_before(self, at_s: float) -> None:
        """Delete older hours."""
        await self._connection.execute(delete(lane_traffic).where(lane_traffic.c.hour_s < at_s))
