"""What must be left in a vehicle's battery: pure arithmetic over the plant's ways."""

from __future__ import annotations

from dray.errors import NoWay
from dray.plant import Plant

RESERVE_FRAC = 0.10
"""Battery that no promise may touch: ways around obstacles, the wait for a charger, and ageing."""

COMPARED = 4
"""Chargers whose ways are compared, the closest as the crow flies."""

NEVER_FRAC = 2.0
"""Stands for "no charger can be reached": more than any battery holds."""


class Reserve:
    """The reserve of one type of vehicle, by place.

    Args:
        plant: where the chargers are.
        vehicle_type: id of the type.
    """

    def __init__(self, plant: Plant, vehicle_type: str) -> None:
        self._plant = plant
        self._type = plant.vehicle_types[vehicle_type]
        self._routes = plant.routes(vehicle_type)
        self._needed_frac: dict[str, float] = {}

    def needed_frac(self, node: str) -> float:
        """What must be left at a node, so that the nearest charger can be reached with the reserve.

        More than a battery holds where no charger can be reached: nothing can be promised that ends there.
        """
        frac = self._needed_frac.get(node)
        if frac is None:
            near = self._plant.closest(node, self._plant.chargers, COMPARED)
            try:
                _, way = self._routes.nearest(node, near)
            except NoWay:
                frac = NEVER_FRAC
            else:
                frac = RESERVE_FRAC + way.length_m * self._type.drive_wh_per_m / self._type.battery_wh
            self._needed_frac[node] = frac
        return frac
