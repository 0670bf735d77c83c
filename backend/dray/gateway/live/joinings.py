"""Joinings: adds machines that the plant file does not know, outside of the event loop.

A plant with one machine more is checked and laid out as a whole. That takes tens of milliseconds to seconds,
while the loop has to serve everybody.
"""

from __future__ import annotations

import asyncio

from dray.gateway.live.projection import Projection
from dray.gateway.live.projection.site import joined
from dray.plant import MachineSpec

TRIES = 5
"""Maximum tries beside the loop. Each begins anew when people define or remove products meanwhile; after the last one the machine
is added on the loop."""


class Joinings:
    """Judges machines one after the other.

    Args:
        projection: its plant is replaced when a machine joins.

    Attributes:
        waiting: those that have introduced themselves and are not judged yet; the site bounds their number.
    """

    def __init__(self, projection: Projection) -> None:
        self._site, self._machines = projection.site, projection.machines
        self.waiting: asyncio.Queue[MachineSpec] = asyncio.Queue()
        self._site.judge = self.waiting.put_nowait

    async def run(self) -> None:
        """Judge machines until cancelled."""
        while True:
            spec = await self.waiting.get()
            try:
                await self._join(spec)
            finally:
                self.waiting.task_done()

    async def _join(self, spec: MachineSpec) -> None:
        for _ in range(TRIES):
            before = self._site.plant
            after = await asyncio.to_thread(joined, before, spec)
            if self._site.plant is before:
                self._site.plant = after or before
                break
        else:
            self._site.join(spec)
        # It has been heard before, under its id alone.
        self._machines.mark((spec.id,))
