"""Lead time of a load: a first estimate until it is measured."""

from __future__ import annotations

from collections.abc import Collection
from math import inf

from dray.plant import Plant
from dray.plant.restrictions import OPEN

TYPICAL_APPROACH_S = 45.0
"""First estimate of a vehicle's approach to a storage (s), until lead times are measured."""


def first_lead_s(plant: Plant, place: str, sources: Collection[str]) -> float:
    """The estimated lead time of a load before any measurement (s).

    The ways ignore present closures, which may be lifted by then. Vehicles without a way do not count.
    """
    node, starts = plant.node_of(place), tuple(map(plant.node_of, sources))
    nearest_s = min(plant.routes(kind, OPEN).nearest_s(starts, node) for kind in plant.vehicle_types)
    handling_s = max(kind.load_s + kind.unload_s for kind in plant.vehicle_types.values())
    return TYPICAL_APPROACH_S + (0.0 if nearest_s == inf else nearest_s) + handling_s
