"""The minimum charge of a vehicle's battery by position: for the way to a charger, and the queue there.

The reserve of a fleet means vehicles instead (`dray.plant.spare_places`). The arithmetic is in
`dray.plant.charger_queue`, which `dray plant check` uses too. This module adds the ways that are open now.
"""

from __future__ import annotations

from collections.abc import Iterable

from dray.errors import NoWay
from dray.plant import Plant, Routes
from dray.plant.charger_queue import SPARE_FRAC
from dray.plant.restrictions import OPEN

COMPARED = 4
"""Chargers whose ways are compared, the closest in a straight line."""

NEVER_FRAC = 2.0
"""Means that no charger can be reached: more than any battery holds."""


class BatteryReserve:
    """The battery reserve of one type of vehicle, by node.

    Args:
        plant: its chargers.
        vehicle_type: id of the type.
    """

    def __init__(self, plant: Plant, vehicle_type: str) -> None:
        self._plant = plant
        self._type = vehicle_type
        self._queue = plant.charger_queue
        self._restrictions = OPEN
        self._needed_frac: dict[str, float] = {}
        """By node, under the present restrictions."""

    def needed_frac(self, node: str) -> float:
        """The charge needed at a node to reach the nearest charger, and to wait while others charge.

        More than a battery holds where no charger can be reached: no task may end there. If all chargers are
        closed, they count as open, because otherwise a closure would end all work.
        """
        if self._restrictions is not self._plant.restrictions:
            self._restrictions = self._plant.restrictions
            self._needed_frac.clear()
        frac = self._needed_frac.get(node)
        if frac is None:
            near = self._plant.closest(node, self._plant.chargers, COMPARED)
            frac = self._to_charger_frac(self._plant.routes(self._type), node, near)
            if frac == NEVER_FRAC and self._restrictions is not OPEN:
                frac = self._to_charger_frac(self._plant.routes(self._type, OPEN), node, near)
            self._needed_frac[node] = frac
        return frac

    def is_enough_after(self, start: str, place: str, battery_frac: float) -> bool:
        """Whether a vehicle can still reach a charger after it has moved to a resting place, or is nearer to one there.

        Args:
            start: the vehicle's node.
            place: the node of the resting place.
            battery_frac: its present charge.
        """
        queue, routes = self._queue, self._plant.routes(self._type)
        near = self._plant.closest(place, self._plant.chargers, COMPARED)
        try:
            there, (_, on) = routes.way(start, place), routes.nearest(place, near)
        except NoWay:
            return True
        used_frac = queue.way_frac(self._type, there.length_m, there.duration_s) - SPARE_FRAC
        if battery_frac - used_frac >= self.needed_frac(place):
            return True
        charger = self.nearest_charger(start)
        return not charger or on.duration_s <= routes.duration_s(start, charger)

    def nearest_charger(self, node: str) -> str:
        """The node of the nearest charger, even if it is occupied; empty if none can be reached."""
        near = self._plant.closest(node, self._plant.chargers, COMPARED)
        try:
            return self._plant.node_of(self._plant.routes(self._type).nearest(node, near)[0])
        except NoWay:
            return ""

    def _to_charger_frac(self, routes: Routes, node: str, near: Iterable[str]) -> float:
        try:
            _, way = routes.nearest(node, near)
        except NoWay:
            return NEVER_FRAC
        return self._queue.needed_frac(self._type, way.length_m, way.duration_s)
