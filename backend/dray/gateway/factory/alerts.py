"""The alert monitor: looks at the plant once a second, and writes down who acknowledges what."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable

from dray.errors import UnavailableError
from dray.gateway.live.projection import Projection
from dray.gateway.live.projection.alerting.alerts import LOOK_S, is_meant
from dray.gateway.live.views import AlertView
from dray.store import Store
from dray.store.factory.acknowledgements import Acknowledgement

_log = logging.getLogger(__name__)


class AlertMonitor:
    """Keeps the alerts of a projection.

    Args:
        projection: what is known of the plant.
        store: keeps acknowledgements.
        wall_s: the wall clock.
    """

    def __init__(self, projection: Projection, store: Store, wall_s: Callable[[], float]) -> None:
        self._projection, self._store, self._wall_s = projection, store, wall_s
        self._writing = asyncio.Lock()
        self._ended: dict[str, float] = {}
        """Acknowledged alerts that have ended and are still in SQL, and when that was seen: bounded as alerts
        are."""

    async def restore(self) -> None:
        """Restore what was acknowledged before the gateway was started."""
        async with self._store.read() as work:
            known = await work.acknowledgements.all()
        self._projection.alerts.restore(known, self._wall_s())

    async def acknowledge(self, alert: str, by: str) -> AlertView | None:
        """Somebody takes an alert on; it is on disk when this returns.

        Args:
            alert: its id.
            by: the person's name.

        Returns:
            The alert with the name of who was first; None when there is no such alert, or no more.
        """
        async with self._writing:
            known = self._projection.alerts.get(alert)
            if known is None or known.acknowledged_by:
                return known
            async with self._store.write() as work:
                first = await work.acknowledgements.get(alert)
                if first is None or not is_meant(known, first):
                    first = Acknowledgement(alert, known.since_at_s, by, self._wall_s())
                    await work.acknowledgements.put(first)
            taken = self._projection.alerts.acknowledge(first)
            if taken is None:
                self._ended[alert] = first.at_s
            else:
                # It has come again: what is in SQL now is of this one.
                self._ended.pop(alert, None)
            return taken

    async def look(self) -> None:
        """Look once, and forget acknowledgements of what has ended."""
        now_s = self._wall_s()
        self._ended.update(dict.fromkeys(self._projection.look(now_s), now_s))
        async with self._writing:
            if not self._ended:
                return
            try:
                async with self._store.write() as work:
                    await work.acknowledgements.drop(self._ended)
            except UnavailableError as error:
                # They stay in SQL, and in the set: the next look tries again.
                _log.warning("ended alerts are not forgotten yet: %s", error)
            else:
                self._ended.clear()

    async def run(self) -> None:
        """Look until cancelled."""
        while True:
            await self.look()
            await asyncio.sleep(LOOK_S)
