"""The road network of a plant: directed lanes between nodes, and which nodes reach which.

`dray.plant.routes` finds ways over it, `dray.plant.floor.motion` tells how long a vehicle takes.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from math import atan2, cos, hypot, radians
from types import MappingProxyType

import msgspec

from dray.plant.model import Door, Lane, LaneType, Node

BEND_RAD = radians(30.0)
"""Up to this angle a vehicle follows the road at full speed; beyond it, it slows down to turn."""

NO_DOORS: Mapping[tuple[str, str], Door] = MappingProxyType({})

_COS_BEND = cos(BEND_RAD)

_ROUNDING = 1e-9
"""A bend of exactly 30 degrees must not count as more because of the last bits of a cosine."""


class DirectedLane(msgspec.Struct, frozen=True, gc=False):
    """A lane in one direction: a lane of the file that runs both ways is two of these."""

    start: str
    end: str
    speed_limit_mps: float
    length_m: float
    heading_rad: float
    """Counter-clockwise from the x axis, in (-pi, pi]."""
    types: tuple[LaneType, ...] = ()
    """As in `dray.plant.model.Lane`."""
    opening_s: float = 0.0
    """How long a vehicle waits at its start until its door is open (s); 0 where there is none."""

    def for_type(self, kind: str) -> DirectedLane | None:
        """The lane with the properties for a type of vehicle; None where it may not."""
        if not self.types:
            return self
        for each in self.types:
            if each.type == kind:
                own_mps = each.speed_limit_mps
                slower = own_mps is not None and own_mps < self.speed_limit_mps
                return msgspec.structs.replace(self, speed_limit_mps=own_mps) if slower else self
        return None


class Roads:
    """Nodes and directed lanes, indexed from both ends.

    Args:
        nodes: the points of the network; their order breaks every tie.
        lanes: lanes as written in the file; every end must be one of `nodes`.
        door_on: the doors on lanes, by the ends of each lane in each direction.
    """

    __slots__ = ("_by_ends", "entering", "lanes", "leaving")

    lanes: tuple[DirectedLane, ...]
    """Lanes in file order; a lane's way back follows directly."""
    leaving: Mapping[str, tuple[DirectedLane, ...]]
    """Node -> lanes that begin there, in the order of `lanes`."""
    entering: Mapping[str, tuple[DirectedLane, ...]]
    """Node -> lanes that end there, in the order of `lanes`."""

    def __init__(
        self,
        nodes: Iterable[Node],
        lanes: Iterable[Lane],
        door_on: Mapping[tuple[str, str], Door] = NO_DOORS,
    ) -> None:
        points = {node.id: node for node in nodes}
        self._index(points, tuple(road for lane in lanes for road in _directed(lane, points, door_on)))

    def for_type(self, kind: str) -> Roads:
        """The lanes on which a type of vehicle may drive, with its limits; itself where all lanes are for all."""
        if not any(lane.types for lane in self.lanes):
            return self
        own = Roads((), ())
        own._index(self.leaving, tuple(lane for each in self.lanes if (lane := each.for_type(kind))))
        return own

    def _index(self, nodes: Iterable[str], lanes: tuple[DirectedLane, ...]) -> None:
        self.lanes = lanes
        leaving: dict[str, list[DirectedLane]] = {node: [] for node in nodes}
        entering: dict[str, list[DirectedLane]] = {node: [] for node in leaving}
        for road in self.lanes:
            leaving[road.start].append(road)
            entering[road.end].append(road)
        self.leaving = {node: tuple(roads) for node, roads in leaving.items()}
        self.entering = {node: tuple(roads) for node, roads in entering.items()}
        self._by_ends = {(road.start, road.end): road for road in self.lanes}

    def lane(self, start: str, end: str) -> DirectedLane | None:
        """The lane that leads straight from one node to another, or None."""
        return self._by_ends.get((start, end))

    def reached_from(self, node: str, blocked: str = "") -> frozenset[str]:
        """All nodes that a vehicle at `node` can drive to, itself included; no vehicle passes the blocked node."""
        return _flood(
            node, {here: [road.end for road in roads] for here, roads in self.leaving.items()}, blocked
        )

    def reaching(self, node: str, blocked: str = "") -> frozenset[str]:
        """All nodes from which a vehicle can drive to `node`, itself included; no vehicle passes the blocked node."""
        return _flood(
            node, {here: [road.start for road in roads] for here, roads in self.entering.items()}, blocked
        )

    def parts(self) -> list[frozenset[str]]:
        """The strongly connected parts: within one, a vehicle gets from every node to every other.

        It takes two passes over all lanes (Kosaraju), so that a file full of loose ends costs no more.
        """
        parts: list[frozenset[str]] = []
        placed: set[str] = set()
        for root in reversed(self._finished()):
            if root in placed:
                continue
            part, open_nodes = {root}, [root]
            while open_nodes:
                for lane in self.entering[open_nodes.pop()]:
                    if lane.start not in placed and lane.start not in part:
                        part.add(lane.start)
                        open_nodes.append(lane.start)
            placed |= part
            parts.append(frozenset(part))
        return parts

    def _finished(self) -> list[str]:
        """All nodes, each after everything that a walk in depth first met beyond it."""
        finished: list[str] = []
        seen: set[str] = set()
        for root in self.leaving:
            if root in seen:
                continue
            seen.add(root)
            walk = [(root, iter(self.leaving[root]))]
            while walk:
                node, lanes = walk[-1]
                ahead = next((lane.end for lane in lanes if lane.end not in seen), None)
                if ahead is None:
                    finished.append(node)
                    walk.pop()
                else:
                    seen.add(ahead)
                    walk.append((ahead, iter(self.leaving[ahead])))
        return finished


def bends(before: DirectedLane, after: DirectedLane) -> bool:
    """Whether a vehicle that goes from one lane into the next must slow down to turn.

    True when the way bends by more than `BEND_RAD`.
    """
    return cos(after.heading_rad - before.heading_rad) < _COS_BEND - _ROUNDING


def _directed(
    lane: Lane, points: Mapping[str, Node], door_on: Mapping[tuple[str, str], Door]
) -> list[DirectedLane]:
    """One lane of the file as one or two directed lanes."""
    ends = [(lane.start, lane.end), (lane.end, lane.start)][: 2 if lane.both_ways else 1]
    roads = []
    for start, end in ends:
        door = door_on.get((start, end))
        dx_m, dy_m = points[end].x_m - points[start].x_m, points[end].y_m - points[start].y_m
        roads.append(
            DirectedLane(
                start,
                end,
                lane.speed_limit_mps,
                hypot(dx_m, dy_m),
                atan2(dy_m, dx_m),
                lane.types,
                0.0 if door is None else door.opening_s,
            )
        )
    return roads


def _flood(node: str, neighbours: Mapping[str, Iterable[str]], blocked: str) -> frozenset[str]:
    """Everything that hangs together with `node` along `neighbours`, other than through a node that is blocked."""
    seen, open_nodes = {node}, [node]
    while open_nodes:
        for other in neighbours[open_nodes.pop()]:
            if other not in seen and other != blocked:
                seen.add(other)
                open_nodes.append(other)
    return frozenset(seen)
