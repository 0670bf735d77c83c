"""A part of a scenario that is played live: in a factory that others watch, and that goes on after it."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from dray.plant import Plant
from dray_sim.factory.sim_factory import SimFactory
from dray_sim.run.evidence import Check
from dray_sim.run.part import Part
from dray_sim.run.stage import Stage


@dataclass(frozen=True, slots=True)
class Ending:
    """The end of a part.

    Attributes:
        at_s: when (plant clock).
        checks: conditions and observations; a broken invariant is one that did not hold.
    """

    at_s: float
    checks: tuple[Check, ...]

    @property
    def held(self) -> bool:
        return bool(self.checks) and all(check.held for check in self.checks)


class LivePlay:
    """One part, played once.

    Args:
        part: to be played.
        plant: where; `part.plant()`.
        seed: of everything random.
        make: makes the factory; see `Stage`.

    Attributes:
        part: as given.
        stage: of this run.
        began_s: plant clock.
        ending: None as long as it is played.
        on_change: called when a step has happened, and at the end.
    """

    def __init__(self, part: Part[Any], plant: Plant, seed: int, make: Callable[..., SimFactory]) -> None:
        self.part = part
        self.stage = Stage(part.shift, plant, seed, part.steps, make)
        self.began_s = self.stage.now_s()
        self.ending: Ending | None = None
        self.on_change: Callable[[], None] = lambda: None
        self.stage.steps.on_change = self._tell

    async def run(self) -> None:
        """Play it, and let the factory go on until cancelled. A broken invariant ends the script and nothing else.

        Raises:
            ExceptionGroup: an agent ended by an exception.
        """
        async with asyncio.TaskGroup() as group:
            group.create_task(self.stage.live())
            group.create_task(self._play())

    async def _play(self) -> None:
        checks = self.stage.checks
        acting = asyncio.ensure_future(self.part.script(self.stage))
        broken = asyncio.create_task(checks.wait_broken())
        try:
            await asyncio.wait({acting, broken}, return_when=asyncio.FIRST_COMPLETED)
            found = () if checks.broken is not None else self.part.judge(await acting)
            unbroken = Check(
                "Every invariant held all the time", checks.broken is None, str(checks.broken or "1 of 1 run")
            )
            self.ending = Ending(self.stage.now_s(), (*found, unbroken))
        finally:
            acting.cancel()
            broken.cancel()
            # From here on there is no reader, and kept messages would only grow.
            self.stage.listeners.clear()
        self._tell()

    def _tell(self) -> None:
        self.on_change()
