"""Dead ends: single-track roads that lead from a fork to an end.

Only one vehicle at a time can get past a node there, so one that comes in and one that comes out would meet without room for either.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from itertools import combinations, pairwise
from math import hypot

from dray.plant import Plant

NODES_MAX = 10
"""Maximum nodes of a dead end beside its docks. With its mouth, a dock, and what a vehicle holds outside, that is no more than the 16 places
that one vehicle may hold in a district."""


def dead_ends(plant: Plant, dock_entries: Mapping[str, str], span_m: float) -> dict[str, str]:
    """Node of a dead end -> the next node on the only way out. The last such node is the fork, its mouth.

    Args:
        plant: the roads.
        dock_entries: dock -> the node before it; a dock makes no fork.
        span_m: the largest straight distance between two nodes of a dead end; longer ones are left out.
    """
    docks_at: dict[str, list[str]] = {}
    for dock, entry in dock_entries.items():
        docks_at.setdefault(entry, []).append(dock)
    roads = plant.roads
    beside = {
        node: ({lane.end for lane in roads.leaving[node]} | {lane.start for lane in roads.entering[node]})
        - dock_entries.keys()
        for node in plant.nodes
        if node not in dock_entries
    }
    outward: dict[str, str] = {}
    for end, others in beside.items():
        if len(others) != 1:
            continue
        road, (onward,) = [end], others
        while len(beside[onward]) == 2:
            (after,) = beside[onward] - {road[-1]}
            road.append(onward)
            onward = after
        if len(beside[onward]) < 3 or len(road) > NODES_MAX:
            continue
        steps = tuple(pairwise((*road, onward)))
        is_single_track = all(roads.lane(here, there) and roads.lane(there, here) for here, there in steps)
        docks = (dock for node in road for dock in docks_at.get(node, ()))
        if is_single_track and _span_m(plant, (*road, *docks, onward)) <= span_m:
            outward.update(steps)
    return outward


def _span_m(plant: Plant, nodes: Iterable[str]) -> float:
    """The largest straight distance between two of these nodes."""
    spots = [plant.nodes[node] for node in nodes]
    return max(hypot(one.x_m - other.x_m, one.y_m - other.y_m) for one, other in combinations(spots, 2))
