"""Kinds of agents, and the groups of them that may send the same messages."""

from __future__ import annotations

from enum import StrEnum


class Kind(StrEnum):
    """The kind of an agent."""

    ATV = "atv"
    MACHINE = "machine"
    STATION = "station"
    """The agent of a storage."""
    STRATEGIST = "strategist"
    GATE = "gate"
    """The agent of the delivery warehouses."""
    OPERATOR = "operator"
    """A person on duty. A gateway speaks for those at its tablets."""
    GATEWAY = "gateway"
    HISTORIAN = "historian"


NOBODY: frozenset[Kind] = frozenset()
VEHICLES = frozenset({Kind.ATV})
MACHINES = frozenset({Kind.MACHINE})
STATIONS = frozenset({Kind.STATION})
STRATEGISTS = frozenset({Kind.STRATEGIST})
GATES = frozenset({Kind.GATE})
GATEWAYS = frozenset({Kind.GATEWAY})
OPERATORS = frozenset({Kind.OPERATOR})
HISTORIANS = frozenset({Kind.HISTORIAN})
BIDDERS = VEHICLES | MACHINES
DOCKS = MACHINES | STATIONS
COORDINATORS = DOCKS | STRATEGISTS
TELLERS = BIDDERS | COORDINATORS | GATES
"""Agents that write history."""
