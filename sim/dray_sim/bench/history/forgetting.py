"""Forgetting as benchmarks watch it: the retention limits, and how long each transaction keeps others from writing."""

from __future__ import annotations

import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

from dray.store import Store, Work
from dray.store.retention import DAY_S, KeptFor
from dray_sim.bench.history.data import NOW_S


def kept_after(before_s: float) -> KeptFor:
    """Retention limits under which only events before this moment (wall clock) are too old."""
    of_events: dict[str, Any] = {"events_s": NOW_S - before_s, "events_most": 1 << 62}
    return KeptFor(**dict.fromkeys(KeptFor.__struct_fields__, NOW_S + DAY_S) | of_events)


class TimedStore(Store):
    """The same database.

    Attributes:
        took_ms: of each transaction, to its end on the disk.
    """

    def __init__(self, store: Store) -> None:
        super().__init__(store.database)
        self.took_ms: list[float] = []

    @asynccontextmanager
    async def write(self) -> AsyncIterator[Work]:
        """See `Store.write`."""
        begun_s = time.perf_counter()
        async with super().write() as work:
            yield work
        self.took_ms.append(1000 * (time.perf_counter() - begun_s))
