"""The roster of a plant: its agents with a process each, and the floor. It is the only such list."""

from __future__ import annotations

from collections.abc import Iterable

from dray.messages.keys import GATE, HISTORIAN
from dray.messages.kinds import Kind
from dray.messages.speakers import names_of
from dray.plant import Plant

FLOOR = "floor"
"""The name of the simulated floor's process, and of its certificate."""


def agents_of(plant: Plant) -> dict[str, Kind]:
    """All agents in the plant file, and the gate, with their kinds, in starting order."""
    return {
        **dict.fromkeys(plant.stores, Kind.STATION),
        **dict.fromkeys(plant.machines, Kind.MACHINE),
        **dict.fromkeys(plant.fleet, Kind.ATV),
        GATE: Kind.GATE,
    }


def certified_of(plant: Plant, strategists: Iterable[str], gateway: str) -> dict[str, dict[str, Kind]]:
    """The agents of each process of a plant, by the name of its certificate."""
    return {
        **{agent: {agent: kind} for agent, kind in agents_of(plant).items()},
        **{strategist: {strategist: Kind.STRATEGIST} for strategist in strategists},
        gateway: names_of(gateway, Kind.GATEWAY),
        HISTORIAN: {HISTORIAN: Kind.HISTORIAN},
    }
