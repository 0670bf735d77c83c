"""Two clocks: the plant's, on which agents live, and the wall's, on which people do.

A simulated factory may run at many times real time. Everything outside of it (REST, SQL, panels) is
on the wall clock; here, and nowhere else, one is turned into the other.
"""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import Callable
from dataclasses import dataclass

from dray.plant.working_time import WorkingTime

LOOK_S = 0.25
"""The wall clock may be set, and need not run as the loop's does: whoever waits for a moment of it looks so often."""


@dataclass(slots=True)
class TimeScale:
    """A straight line from the plant's clock to the wall clock. It moves where a simulated plant's clock stands (`stood`).

    Attributes:
        plant_epoch_s: a moment on the plant's clock...
        wall_epoch_s: ...and the same moment on the wall clock, in seconds since 1970.
        speed: factory seconds per real second; above 0.
    """

    plant_epoch_s: float
    wall_epoch_s: float
    speed: float = 1.0

    def __post_init__(self) -> None:
        if not self.speed > 0:
            raise ValueError(f"a speed is above 0: {self.speed}")

    def stood(self, stood_s: float) -> None:
        """The plant's clock has stood for so long (wall seconds), since its computer could not keep up: what it shows is later on the wall."""
        self.wall_epoch_s += stood_s

    def to_wall_s(self, plant_s: float) -> float:
        """Plant clock to wall clock."""
        return self.wall_epoch_s + (plant_s - self.plant_epoch_s) / self.speed

    def to_plant_s(self, wall_s: float) -> float:
        """Wall clock to plant clock."""
        return self.plant_epoch_s + (wall_s - self.wall_epoch_s) * self.speed


async def wait_until(at_s: float, wall_s: Callable[[], float], news: asyncio.Event | None = None) -> None:
    """Return when the wall clock shows `at_s`, or before, when `news` is set.

    Args:
        at_s: a moment on the wall clock; infinite for never.
        wall_s: the wall clock.
        news: what ends the wait, too.
    """
    while (left_s := at_s - wall_s()) > 0 and not (news is not None and news.is_set()):
        if news is None:
            await asyncio.sleep(min(left_s, LOOK_S))
        else:
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(min(left_s, LOOK_S)):
                    await news.wait()


class WallWorkingTime:
    """When a machine works, on the wall clock.

    Args:
        working_time: by the plant's clock.
        time: of the plant.
    """

    def __init__(self, working_time: WorkingTime, time: TimeScale) -> None:
        self._working_time, self._time = working_time, time

    def between_s(self, start_s: float, end_s: float) -> float:
        """Working time from one moment to another one (wall seconds)."""
        time = self._time
        return self._working_time.between_s(time.to_plant_s(start_s), time.to_plant_s(end_s)) / time.speed

    def after_s(self, start_s: float, work_s: float) -> float:
        """When so much working time has passed (wall clock); infinite for never."""
        time = self._time
        return time.to_wall_s(self._working_time.after_s(time.to_plant_s(start_s), work_s * time.speed))
