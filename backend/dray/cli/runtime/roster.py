"""The roster of a plant: its agents that have a process each, and the floor. The one list of them."""

from __future__ import annotations

from dray.messages.keys import GATE
from dray.messages.speakers import Kind
from dray.plant import Plant

FLOOR = "floor"
"""The name of the simulated floor's process, and of its certificate."""


def agents_of(plant: Plant) -> dict[str, Kind]:
    """All agents that the plant file names, its gate, and what they are, in the order in which they are started."""
    return {
        **dict.fromkeys(plant.stores, Kind.STATION),
        **dict.fromkeys(plant.machines, Kind.MACHINE),
        **dict.fromkeys(plant.fleet, Kind.ATV),
        GATE: Kind.GATE,
    }
