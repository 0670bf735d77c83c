"""Where an agent stands that does not drive."""

from __future__ import annotations

from dray.messages.keys import GATE
from dray.plant import Plant


def places_of(plant: Plant, agent: str) -> tuple[str, ...]:
    """The places of a machine, a storage's or a warehouse's station, or the gate; of the gate all delivery warehouses, of any other none."""
    if agent == GATE:
        return plant.delivery_warehouses
    return (agent,) if agent in plant.machines or agent in plant.stores else ()


def areas_of(plant: Plant, agent: str) -> frozenset[str]:
    """The areas in which it stands."""
    places = places_of(plant, agent)
    return frozenset(area for place in places for area in plant.areas_near(*plant.position_of(place), 0.0))
