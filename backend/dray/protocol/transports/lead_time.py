"""How long it takes until a load is brought: a first guess, until that is measured."""

from __future__ import annotations

from collections.abc import Iterable

from dray.plant import Plant

TYPICAL_APPROACH_S = 45.0
"""A first guess of how long a vehicle needs to reach a storage, until lead times are measured."""


def first_lead_s(plant: Plant, place: str, sources: Iterable[str]) -> float:
    """How long it takes until a load is brought, before anything was learned of it (s)."""
    node = plant.node_of(place)
    ways_s = [
        plant.routes(kind).duration_s(plant.node_of(source), node)
        for source in sources
        for kind in plant.vehicle_types
    ]
    handling_s = max(kind.load_s + kind.unload_s for kind in plant.vehicle_types.values())
    return TYPICAL_APPROACH_S + min(ways_s) + handling_s
