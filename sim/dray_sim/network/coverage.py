"""The WLAN's coverage: access points with a range, and holes in between.

Only vehicles ask, for all others are wired. A place is covered when an access point that is up is in
range and no hole is over it. How a vehicle notices that it has left the coverage is `dray_sim.network.modem`.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from math import ceil, hypot, sqrt
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from dray.plant import Plant

RANGE_M = 30.0
"""An indoor access point among steel racks and machines."""


@dataclass(frozen=True, slots=True)
class AccessPoint:
    """One access point and how far it reaches."""

    id: str
    x_m: float
    y_m: float
    range_m: float = RANGE_M


@dataclass(frozen=True, slots=True)
class Hole:
    """A circle that no access point reaches."""

    x_m: float
    y_m: float
    radius_m: float


def access_points_of(plant: Plant, range_m: float = RANGE_M) -> tuple[AccessPoint, ...]:
    """A square grid of access points that leaves no point of the floor uncovered.

    Args:
        plant: its floor.
        range_m: of every access point; the grid's squares have this as half their diagonal, or less.

    Returns:
        The access points AP1, AP2 and so on, row by row from below.
    """
    side_m = range_m * sqrt(2.0)
    columns, rows = ceil(plant.width_m / side_m), ceil(plant.height_m / side_m)
    return tuple(
        AccessPoint(
            f"AP{row * columns + column + 1}",
            (column + 0.5) * plant.width_m / columns,
            (row + 0.5) * plant.height_m / rows,
            range_m,
        )
        for row in range(rows)
        for column in range(columns)
    )


class Coverage:
    """The area that the access points reach. Immutable: another state is another object.

    Args:
        access_points: all that there are; without any, the WLAN is everywhere but in the holes.
        holes: where none of them reaches.
        down: ids of those that are off.
        whole: the access points are known to leave nothing uncovered while all are up.

    Attributes:
        perfect: whether every place is covered, so that no check is needed.
    """

    def __init__(
        self,
        access_points: Iterable[AccessPoint] = (),
        holes: Iterable[Hole] = (),
        down: Iterable[str] = (),
        *,
        whole: bool = False,
    ) -> None:
        self.access_points = tuple(access_points)
        self.holes = tuple(holes)
        self.down = tuple(down)
        self.whole = whole or not self.access_points
        self.perfect = self.whole and not self.holes and not self.down
        self._up = tuple(point for point in self.access_points if point.id not in self.down)

    @classmethod
    def of_plant(cls, plant: Plant, range_m: float = RANGE_M) -> Coverage:
        """The whole floor, by as many access points as that takes."""
        return cls(access_points_of(plant, range_m), whole=True)

    def with_faults(self, holes: Iterable[Hole], down: Iterable[str]) -> Coverage:
        """The same with more holes, and more access points off."""
        return Coverage(self.access_points, (*self.holes, *holes), (*self.down, *down), whole=self.whole)

    def nearest(self, x_m: float, y_m: float) -> str:
        """The access point that a point is served by while all are up; empty for none."""
        near = [(hypot(x_m - point.x_m, y_m - point.y_m), point) for point in self.access_points]
        served = [(away_m, point.id) for away_m, point in near if away_m <= point.range_m]
        return min(served, default=(0.0, ""))[1]

    def covers(self, x_m: float, y_m: float) -> bool:
        """Whether the WLAN reaches a point; a circle's edge belongs to it."""
        if self.perfect:
            return True
        if any(hypot(x_m - hole.x_m, y_m - hole.y_m) <= hole.radius_m for hole in self.holes):
            return False
        if not self.access_points:
            return True
        return any(hypot(x_m - point.x_m, y_m - point.y_m) <= point.range_m for point in self._up)
