"""Places of agents that do not drive."""

from __future__ import annotations

from dray.messages.keys import GATE
from dray.plant import Plant


def places_of(plant: Plant, agent: str) -> tuple[str, ...]:
    """The places of a machine, a station or the gate (all delivery warehouses); none for other agents."""
    if agent == GATE:
        return plant.delivery_warehouses
    return (agent,) if agent in plant.machines or agent in plant.stores else ()


def areas_of(plant: Plant, agent: str) -> frozenset[str]:
    """The areas in which an agent stands."""
    places = places_of(plant, agent)
    return frozenset(area for place in places for area in plant.areas_near(*plant.position_of(place), 0.0))
