"""Two clocks: the plant's clock for agents, and the wall clock for people.

A simulated factory may run at many times real time. Everything outside of it (REST, SQL, panels) uses the
wall clock. Only this module converts between them.
"""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import Callable
from dataclasses import dataclass

from dray.plant.working_time import WorkingTime

LOOK_S = 0.25
"""Seconds between two looks at the wall clock while waiting: it may be set, and may run at another rate than
the loop's clock."""


@dataclass(slots=True)
class TimeScale:
    """A linear map from plant clock to wall clock. It shifts when a simulated plant's clock stops (`stood`).

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
        """Shift the map: the plant's clock stood still for these wall seconds (a slow computer)."""
        self.wall_epoch_s += stood_s

    def to_wall_s(self, plant_s: float) -> float:
        """Plant clock to wall clock."""
        return self.wall_epoch_s + (plant_s - self.plant_epoch_s) / self.speed

    def to_plant_s(self, wall_s: float) -> float:
        """Wall clock to plant clock."""
        return self.plant_epoch_s + (wall_s - self.wall_epoch_s) * self.speed


async def wait_until(at_s: float, wall_s: Callable[[], float], news: asyncio.Event | None = None) -> None:
    """Return when the wall clock shows `at_s`, or when `news` is set before.

    Args:
        at_s: a moment on the wall clock; infinite for never.
        wall_s: the wall clock.
        news: also ends the wait.
    """
    while (left_s := at_s - wall_s()) > 0 and not (news is not None and news.is_set()):
        if news is None:
            await asyncio.sleep(min(left_s, LOOK_S))
        else:
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(min(left_s, LOOK_S)):
                    await news.wait()


class WallWorkingTime:
    """A machine's working time on the wall clock.

    Args:
        working_time: on the plant's clock.
        time: the plant's clocks.
    """

    def __init__(self, working_time: WorkingTime, time: TimeScale) -> None:
        self._working_time, self._time = working_time, time

    def between_s(self, start_s: float, end_s: float) -> float:
        """Working time between two moments (wall seconds)."""
        time = self._time
        return self._working_time.between_s(time.to_plant_s(start_s), time.to_plant_s(end_s)) / time.speed

    def after_s(self, start_s: float, work_s: float) -> float:
        """The moment when so much working time has passed (wall clock); infinite for never."""
        time = self._time
        return time.to_wall_s(self._working_time.after_s(time.to_plant_s(start_s), work_s * time.speed))
