"""The sampler: stores every wall minute what the factory's figures and lane traffic have added.

Several gateways see the same factory, and a minute must not be counted twice. The first one writes it, and
the others skip it. When a gateway starts or stops within a minute, the rest of that minute may be missing.
"""

from __future__ import annotations

import logging
from collections.abc import Callable

import msgspec

from dray.errors import UnavailableError
from dray.gateway.live.projection import Projection
from dray.gateway.live.projection.figures.traffic import lanes_added
from dray.gateway.live.timescale import wait_until
from dray.store import Store
from dray.store.factory.kpis import KpiSample

SAMPLE_S = 60.0
"""Wall seconds between two samples: people look at hours, but a quarter of an hour should show its course."""

KEPT_S = 35 * 86_400.0
"""Retention of lane traffic, and maximum span of one answer: a month with its ends, some 50,000 rows."""

AS_THEY_ARE = ("at_s", "transport_p50_s", "transport_p95_s")
"""Fields that are no sums."""

_log = logging.getLogger(__name__)


class Sampler:
    """Samples the projection.

    Args:
        projection: the live projection.
        store: the database.
        wall_s: the wall clock.
    """

    def __init__(self, projection: Projection, store: Store, wall_s: Callable[[], float]) -> None:
        self._projection, self._store, self._wall_s = projection, store, wall_s
        self._before = projection.totals(wall_s())
        """Totals at the end of the last sample written, by any gateway."""
        self._lanes_before = projection.traffic.totals()

    async def run(self) -> None:
        """Sample at every full minute, until cancelled."""
        while True:
            now_s = self._wall_s()
            await wait_until(now_s + SAMPLE_S - now_s % SAMPLE_S, self._wall_s)
            await self.sample()

    async def sample(self) -> None:
        """Store what was added since the last sample, unless another gateway has stored that time.

        What cannot be written is in the next sample.
        """
        totals, lanes = self._projection.totals(self._wall_s()), self._projection.traffic.totals()
        sample = added(self._before, totals)
        if sample.span_s <= 0:
            return
        try:
            async with self._store.write() as work:
                newest_at_s = await work.kpis.newest_at_s()
                if newest_at_s is None or newest_at_s <= self._before.at_s:
                    await work.kpis.add(sample)
                    await work.lane_hours.add(totals.at_s, lanes_added(self._lanes_before, lanes))
                    await work.lane_hours.forget_before(totals.at_s - KEPT_S)
        except UnavailableError as error:
            _log.warning("the factory's figures cannot be written: %s", error)
        else:
            self._before, self._lanes_before = totals, lanes


def added(before: KpiSample, after: KpiSample) -> KpiSample:
    """The difference of two totals."""
    differences = {
        name: getattr(after, name) - getattr(before, name)
        for name in KpiSample.__struct_fields__
        if name not in AS_THEY_ARE
    }
    return msgspec.structs.replace(after, **differences)
