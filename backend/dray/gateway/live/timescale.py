"""Two clocks: the plant's, on which agents live, and the wall's, on which people do.

A simulated factory may run at many times real time. Everything outside of it (REST, SQL, panels) is
on the wall clock; here, and nowhere else, one is turned into the other.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class TimeScale:
    """A straight line from the plant's clock to the wall clock.

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

    def to_wall_s(self, plant_s: float) -> float:
        """Plant clock to wall clock."""
        return self.wall_epoch_s + (plant_s - self.plant_epoch_s) / self.speed

    def to_plant_s(self, wall_s: float) -> float:
        """Wall clock to plant clock."""
        return self.plant_epoch_s + (wall_s - self.wall_epoch_s) * self.speed
