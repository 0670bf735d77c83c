"""Dead ends: single-track roads that lead from a fork to an end.

Vehicles cannot pass one another there, so one that waits inside is in the only way out of those that are farther in.
"""

from __future__ import annotations

from collections.abc import Container, Iterable, Mapping
from itertools import combinations, pairwise, starmap
from math import hypot

from dray.plant import Plant
from dray.plant.restrictions import Ends

NODES_MAX = 10
"""Maximum nodes of a dead end beside its docks. With the fork, a dock, and what a vehicle holds outside, these are no more
than the 16 places that one vehicle may hold in a district."""


def dead_ends(
    plant: Plant, dock_entries: Mapping[str, str], crossed: Container[Ends], span_m: float
) -> dict[str, str]:
    """The dead ends of a plant.

    Args:
        plant: the roads.
        dock_entries: dock -> the node before it; a dock at the end of a spur makes no fork.
        crossed: lanes that need a crossing; no dead end has one.
        span_m: the largest straight distance between two nodes of a dead end; longer ones are left out.

    Returns:
        Node of a dead end -> the next node on the only way out. The last such node is the fork.
    """
    roads = plant.roads
    beside = {
        node: {lane.end for lane in roads.leaving[node]} | {lane.start for lane in roads.entering[node]}
        for node in plant.nodes
    }
    spurs = {dock: entry for dock, entry in dock_entries.items() if beside[dock] == {entry}}
    beside = {node: others - spurs.keys() for node, others in beside.items() if node not in spurs}

    def is_single_track(one: str, other: str) -> bool:
        ways = ((one, other), (other, one))
        return all(roads.lane(*way) is not None and way not in crossed for way in ways)

    outward: dict[str, str] = {}
    for end, others in beside.items():
        if len(others) != 1:
            continue
        way = _way_out(end, beside)
        *road, fork = way
        if len(beside[fork]) < 3 or len(road) > NODES_MAX:
            continue
        docks = [dock for dock, entry in spurs.items() if entry in road]
        steps = tuple(pairwise(way))
        if all(starmap(is_single_track, steps)) and _span_m(plant, (*way, *docks)) <= span_m:
            outward.update(steps)
    return outward


def _way_out(end: str, beside: Mapping[str, set[str]]) -> list[str]:
    """The nodes from the end of a road to its fork, or to its other end.

    Args:
        end: a node with one node beside it.
        beside: node -> the nodes beside it.
    """
    way, (onward,) = [end], beside[end]
    while len(beside[onward]) == 2:
        (after,) = beside[onward] - {way[-1]}
        way.append(onward)
        onward = after
    return [*way, onward]


def _span_m(plant: Plant, nodes: Iterable[str]) -> float:
    """The largest straight distance between two of these nodes."""
    spots = [plant.nodes[node] for node in nodes]
    return max(hypot(one.x_m - other.x_m, one.y_m - other.y_m) for one, other in combinations(spots, 2))
