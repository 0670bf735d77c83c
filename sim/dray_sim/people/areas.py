"""The operator who is responsible for a part of the floor."""

from __future__ import annotations

from dray.plant import Plant

EVERYWHERE = "plant"
"""The area of the only operator of a plant that has no areas."""


def area_at(plant: Plant, x_m: float, y_m: float) -> str:
    """The one area whose operator is responsible for a point.

    On a common border that is the first area in the plant file; outside all areas, the one with the closest corner;
    `EVERYWHERE` where the plant has none.
    """
    areas = plant.areas_at(x_m, y_m)
    if areas:
        return areas[0]
    away_m2 = {
        area.id: min((corner.x_m - x_m) ** 2 + (corner.y_m - y_m) ** 2 for corner in area.polygon)
        for area in plant.areas.values()
    }
    return min(away_m2, key=away_m2.__getitem__, default=EVERYWHERE)
