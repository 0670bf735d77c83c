"""Restrictions by people of a plant's lanes: closed, slow or one-way ones."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from math import ceil

import msgspec
from msgspec.structs import replace

from dray.plant.floor.geometry import box_of, inside
from dray.plant.layout import name_after, name_before
from dray.plant.model import Node, PlantFile, Point
from dray.plant.roads import DirectedLane, Roads

Ends = tuple[str, str]
"""A lane in one direction, by its nodes."""

SAMPLE_M = 0.25
"""Step of the search along a lane that may cross an area: a shorter contact is no crossing."""


class Restrictions(msgspec.Struct, frozen=True):
    """Restrictions of one plant at one moment. Equal ones are equal, so that ways are looked for once."""

    nodes: frozenset[str] = frozenset()
    """Closed nodes: no vehicle enters them from outside. A vehicle inside may drive through them on its way out."""
    lanes: frozenset[Ends] = frozenset()
    """Closed lanes: no vehicle enters them from anywhere."""
    limits_mps: tuple[tuple[Ends, float], ...] = ()
    """The highest speeds on slow lanes, sorted, each lane once."""

    def admits(self, start: str, end: str) -> bool:
        """Whether a vehicle at one end of a lane may enter it."""
        return (start, end) not in self.lanes and (end not in self.nodes or start in self.nodes)

    def open_lanes(self, roads: Roads) -> dict[str, tuple[DirectedLane, ...]]:
        """The lanes that may be entered, by the node where they begin, each with the speed that holds there."""
        if not (self.nodes or self.lanes or self.limits_mps):
            return dict(roads.leaving)
        limits_mps = dict(self.limits_mps)
        return {
            node: tuple(
                _limited(lane, limits_mps.get((lane.start, lane.end)))
                for lane in lanes
                if self.admits(lane.start, lane.end)
            )
            for node, lanes in roads.leaving.items()
        }

    def limits_on(self, nodes: tuple[str, ...]) -> tuple[float | None, ...]:
        """The speed limits along a way (m/s), one per lane, None for an unrestricted lane; empty where all are unrestricted."""
        if not self.limits_mps:
            return ()
        limits_mps = dict(self.limits_mps)
        found = tuple(limits_mps.get(ends) for ends in pairwise(nodes))
        return found if any(limit is not None for limit in found) else ()


OPEN = Restrictions()
"""No restrictions."""


class Extent(msgspec.Struct, frozen=True):
    """The nodes and lanes in an area."""

    nodes: frozenset[str]
    """Borders included."""
    across: frozenset[Ends]
    """Lanes that run through it between two nodes outside of it."""


def extent_of(polygon: Sequence[Point], nodes: Mapping[str, Node], roads: Roads) -> Extent:
    """The nodes and lanes of a part of the floor."""
    inside_it = frozenset(node.id for node in nodes.values() if _within(node, polygon))
    left_m, low_m, right_m, high_m = box_of(polygon)
    across = []
    for lane in roads.lanes:
        start, end = nodes[lane.start], nodes[lane.end]
        if (
            {start.id, end.id} & inside_it
            or max(start.x_m, end.x_m) < left_m
            or min(start.x_m, end.x_m) > right_m
            or max(start.y_m, end.y_m) < low_m
            or min(start.y_m, end.y_m) > high_m
        ):
            continue
        steps = ceil(lane.length_m / SAMPLE_M)
        if any(_within(_between(start, end, step / steps), polygon) for step in range(1, steps)):
            across.append((lane.start, lane.end))
    return Extent(inside_it, frozenset(across))


def opposite_stops(file: PlantFile, nodes: Mapping[str, Node]) -> dict[str, str]:
    """The stop points of two-lane roads, each with the one that lies opposite on the lane that leads back.

    Args:
        file: the plant as it is drawn.
        nodes: of its floor as it is driven.
    """
    found: dict[str, str] = {}
    for lane in file.lanes:
        for start, end in ((lane.start, lane.end), (lane.end, lane.start)):
            first, back = name_after(start, end), name_after(end, start)
            if first in nodes and back in nodes:
                last = name_before(end, start)
                found[first] = last if last in nodes else back
                found[found[first]] = first
    return found


def _within(node: Node, polygon: Sequence[Point]) -> bool:
    return inside(Point(node.x_m, node.y_m), polygon)


def _between(start: Node, end: Node, part: float) -> Node:
    return Node("", start.x_m + part * (end.x_m - start.x_m), start.y_m + part * (end.y_m - start.y_m))


def _limited(lane: DirectedLane, limit_mps: float | None) -> DirectedLane:
    if limit_mps is None or limit_mps >= lane.speed_limit_mps:
        return lane
    return replace(lane, speed_limit_mps=limit_mps)
