"""Where a vehicle waits that has no berth: out of everybody's way, at a node where nobody docks."""

from __future__ import annotations

from heapq import nsmallest
from math import hypot

from dray.errors import NoWay
from dray.plant import Plant
from dray.protocol.reserve import COMPARED, NEVER_FRAC, Reserve


class Aside:
    """The places beside the docks, for one type of vehicle.

    Args:
        plant: where docks and lanes are.
        vehicle_type: id of the type, for its ways.
    """

    def __init__(self, plant: Plant, vehicle_type: str) -> None:
        self._plant = plant
        self._routes = plant.routes(vehicle_type)
        self._reserve = Reserve(plant, vehicle_type)
        docks = {plant.node_of(place) for place in plant.places}
        free = tuple(node for node in plant.nodes if node not in docks)
        # Material comes from a source warehouse by other means than these vehicles.
        self._spots = free or tuple(plant.node_of(place) for place in plant.source_warehouses)

    def nearest(self, node: str) -> str:
        """The nearest such node, perhaps this one; this one too where there is none."""
        here = self._plant.nodes[node]

        def distance_m(spot: str) -> float:
            there = self._plant.nodes[spot]
            return hypot(there.x_m - here.x_m, there.y_m - here.y_m)

        found, least_s = node, float("inf")
        for spot in nsmallest(COMPARED, self._spots, key=distance_m):
            try:
                way_s = self._routes.duration_s(node, spot)
            except NoWay:
                continue
            # Not into a dead end that leads to no dock.
            if way_s < least_s and self._reserve.needed_frac(spot) < NEVER_FRAC:
                found, least_s = spot, way_s
        return found
