"""The alert desk: looks at the plant once a second, and writes down who acknowledges what."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable

from dray.errors import UnavailableError
from dray.gateway.projection import Projection
from dray.gateway.views import AlertView
from dray.store import Store
from dray.store.acknowledgements import Acknowledgement

LOOK_S = 1.0
"""Between two looks: sooner than anybody could do something about it."""

_log = logging.getLogger(__name__)


class AlertDesk:
    """Keeps the alerts of a projection.

    Args:
        projection: what is known of the plant.
        store: keeps acknowledgements.
        wall_s: the wall clock.
    """

    def __init__(self, projection: Projection, store: Store, wall_s: Callable[[], float]) -> None:
        self._projection, self._store, self._wall_s = projection, store, wall_s
        self._writing = asyncio.Lock()
        self._ended: set[str] = set()
        """Acknowledged alerts that have ended and are still in SQL: bounded as alerts are."""

    async def begin(self) -> None:
        """Recall what was acknowledged before the gateway was started."""
        async with self._store.read() as work:
            known = await work.acknowledgements.all()
        self._projection.alerts.begin(known, self._wall_s())

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
            acknowledgement = Acknowledgement(alert, known.since_at_s, by, self._wall_s())
            async with self._store.write() as work:
                await work.acknowledgements.put(acknowledgement)
            taken = self._projection.alerts.acknowledge(acknowledgement)
            if taken is None:
                self._ended.add(alert)
            else:
                # It has come again: what is in SQL now is of this one.
                self._ended.discard(alert)
            return taken

    async def look(self) -> None:
        """Look once, and forget acknowledgements of what has ended."""
        self._ended.update(self._projection.look(self._wall_s()))
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
