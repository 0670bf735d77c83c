"""How long it takes until a load is brought: a first guess, until that is measured."""

from __future__ import annotations

from collections.abc import Collection
from math import inf

from dray.plant import Plant
from dray.plant.restrictions import OPEN

TYPICAL_APPROACH_S = 45.0
"""A first guess of how long a vehicle needs to reach a storage, until lead times are measured."""


def first_lead_s(plant: Plant, place: str, sources: Collection[str]) -> float:
    """How long it takes until a load is brought, before anything was learned of it (s).

    The ways are those of the plant file: what is closed at the moment may be open when somebody comes. Vehicles that have none count for nothing.
    """
    node, starts = plant.node_of(place), tuple(map(plant.node_of, sources))
    nearest_s = min(plant.routes(kind, OPEN).nearest_s(starts, node) for kind in plant.vehicle_types)
    handling_s = max(kind.load_s + kind.unload_s for kind in plant.vehicle_types.values())
    return TYPICAL_APPROACH_S + (0.0 if nearest_s == inf else nearest_s) + handling_s
