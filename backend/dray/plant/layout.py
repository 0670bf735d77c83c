"""The floor as vehicles drive on it: worked out from the nodes and lanes of a plant file.

Without two-lane roads it is the floor of the file. A road of two lanes becomes two lanes with room between them, each
on the right of the middle. A node where such roads meet becomes a *crossing*: vehicles cross it one at a time and
never stop in it. They stop before and after it, at *stop points* on their own lane. There a crossing vehicle does not
touch them. Widths and distances follow from the largest vehicle of the plant.

    a --- b --- c        the lane from a to b:    a.to-b -> b.from-a
          |              straight on over b:                b.from-a -> b.to-c
          d              to the dock d of a spur:           b.from-a -> b -> d

A vehicle goes from stop point to stop point in a straight line: a right turn is short, a left turn goes across.
Spurs, docks and other single tracks stay as they are, and begin in the middle of the crossing. Where a road is too
short for a stop point, the crossings at its ends are merged; so are crossings that a single track joins.

Other modules decide which vehicle may cross next, and find narrow places (`dray.plant.planning.advice_floor`).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from hashlib import sha256
from itertools import pairwise
from math import atan2, cos, hypot, pi, sin, sqrt

import msgspec

from dray.plant.floor.rectangles import Rectangle, standing
from dray.plant.floor.road import Road, over_crossing
from dray.plant.model import Lane, Node, PlantFile, VehicleType

PASSING_M = 0.4
"""Distance between two vehicles that meet, as German workplace rules want it (ASR A1.8, passing allowance Z2)."""

MARGIN_M = 0.2
"""Margin between a vehicle at a stop point and one that crosses or turns: the error of localisation and control."""

SQRT_2 = sqrt(2.0)
"""A left turn leads across at half a right angle."""

LONGEST_ID = 32
"""Characters of an id (`dray.plant.model.Id`)."""

DIGEST_CHARS = 8
"""Digest characters in the names of stop points that would be too long."""


class Size(msgspec.Struct, frozen=True):
    """The largest of some types of vehicles, each measure by itself, and the distances that follow from it (m)."""

    length_m: float
    width_m: float
    turning_radius_m: float

    @classmethod
    def of(cls, kinds: Iterable[VehicleType]) -> Size:
        """The largest dimensions of some types of vehicles; at least one."""
        kinds = tuple(kinds)
        return cls(
            max(kind.length_m for kind in kinds),
            max(kind.width_m for kind in kinds),
            max(kind.turning_radius_m for kind in kinds),
        )

    def at(self, node: Node, heading_rad: float) -> Rectangle:
        """The area of such a vehicle that stands on a node."""
        return standing(node, heading_rad, self.length_m, self.width_m)

    @property
    def offset_m(self) -> float:
        """Distance from the middle of a two-lane road to each of its lanes.

        At this distance two vehicles pass, and both may turn on the spot beside one another. A vehicle that turns
        left at a crossing is clear of one that has just left the crossing on the first one's road.
        """
        left_turn_m = (self.turning_radius_m + self.width_m / 2.0 + MARGIN_M / 2.0) * SQRT_2
        return max(self.width_m + PASSING_M, 2.0 * self.turning_radius_m + MARGIN_M / 2.0, left_turn_m) / 2.0

    @property
    def spacing_m(self) -> float:
        """Distance between two stop points: one vehicle stands, the other turns on the spot."""
        return self.length_m / 2.0 + self.turning_radius_m + MARGIN_M


class Crossing(msgspec.Struct, frozen=True):
    """A part of the floor that one vehicle at a time crosses, and where none stops."""

    id: str
    """Its first node in the plant file. It is a node of the floor only where a single track begins in it. A lane with a shape
    is a crossing, too: it has the name of its first corner's lane (`dray.plant.floor.shapes`)."""
    nodes: tuple[str, ...]
    """Nodes of the plant file: more than one where there is no stop point between them; none for a lane with a shape."""
    x_m: float
    y_m: float
    """Position of its middle."""
    entries: tuple[str, ...]
    """Nodes where vehicles stand before they cross it."""
    exits: tuple[str, ...]
    """Nodes where vehicles stand after they have crossed it: a vehicle enters it only if it may drive on to one of
    these."""
    lanes: tuple[tuple[str, str], ...]
    """Lanes into it, through it or out of it, by their ends."""
    inner: tuple[str, ...]
    """Nodes of the floor that lie in it: no vehicle stops there."""


class Layout(msgspec.Struct, frozen=True):
    """Nodes and lanes as they are driven."""

    nodes: tuple[Node, ...]
    """Nodes of the file that are driven to, then stop points in the order of the lanes."""
    lanes: tuple[Lane, ...]
    """None of them has two lanes."""
    crossings: Mapping[str, Crossing]
    """Crossings by id, in file order."""
    inner: Mapping[str, str]
    """Node of the floor that lies in a crossing -> its id. All other nodes are where a vehicle may stand."""
    crossed: Mapping[tuple[str, str], str]
    """Lane, by its ends -> the crossing that it leads into, through or out of."""
    corners: Mapping[tuple[str, str], tuple[str, ...]] = {}
    """Lane with a shape, by its ends -> the nodes at its corners, in the order in which they are driven over."""


def lay_out(file: PlantFile) -> Layout:
    """The floor of a plant file whose ids and references are right; lanes with a shape are still whole (`dray.plant.floor.shapes`)."""
    if not any(_has_two_lanes(lane, file, frozenset()) for lane in file.lanes):
        return Layout(file.nodes, file.lanes, {}, {}, {})
    return _Draft(file).layout()


def stop_names(file: PlantFile) -> frozenset[str]:
    """The ids that stop points of this file may have."""
    return frozenset(
        name for start, end in _both(file.lanes) for name in (name_after(start, end), name_before(start, end))
    )


def stop_points(file: PlantFile) -> frozenset[str]:
    """The stop points of a file; none where its lanes have unknown ends."""
    nodes = {node.id for node in file.nodes}
    if not all(end in nodes for lane in file.lanes for end in (lane.start, lane.end)):
        return frozenset()
    layout = lay_out(file)
    return frozenset(node.id for node in layout.nodes if node.id not in nodes and node.id not in layout.inner)


def name_after(start: str, end: str) -> str:
    """The stop point of the lane from `start` to `end` that comes first."""
    return short_name(f"{start}.to-{end}")


def name_before(start: str, end: str) -> str:
    """The stop point of the lane from `start` to `end` that comes last, where there is room for two."""
    return short_name(f"{end}.from-{start}")


def dock_nodes(file: PlantFile) -> frozenset[str]:
    """Nodes where vehicles dock, charge or park."""
    return frozenset(
        place.node
        for places in (file.machines, file.storages, file.warehouses, file.chargers, file.parkings)
        for place in places
    )


def _has_two_lanes(lane: Lane, file: PlantFile, docks: frozenset[str]) -> bool:
    wanted = file.two_lanes if lane.two_lanes is None else lane.two_lanes
    straight = not lane.shape
    return wanted and straight and lane.both_ways and lane.start not in docks and lane.end not in docks


def _both(lanes: Iterable[Lane]) -> list[tuple[str, str]]:
    """Every direction of every lane."""
    return [
        ends
        for lane in lanes
        for ends in ((lane.start, lane.end), (lane.end, lane.start))[: 2 if lane.both_ways else 1]
    ]


def short_name(name: str) -> str:
    """A name that is made of others; at most as long as an id may be."""
    if len(name) <= LONGEST_ID:
        return name
    digest = sha256(name.encode()).hexdigest()[:DIGEST_CHARS]
    return f"{name[: LONGEST_ID - DIGEST_CHARS - 1]}.{digest}"


class _Draft:
    """A floor in the making.

    Args:
        file: with one two-lane road or more.
    """

    def __init__(self, file: PlantFile) -> None:
        self._file = file
        self._size = Size.of(file.vehicle_types)
        self._points = {node.id: node for node in file.nodes}
        docks = dock_nodes(file)
        wide = [lane for lane in file.lanes if _has_two_lanes(lane, file, docks)]
        self._ends = {end for lane in wide for end in (lane.start, lane.end)}
        """The nodes that become crossings."""
        self._wide = {(lane.start, lane.end) for lane in wide}
        self._roads: dict[Lane, tuple[Road, ...]] = {}
        """Roads that replace a lane between crossings; other lanes stay as they are."""
        for lane in file.lanes:
            if lane.start in self._ends and lane.end in self._ends:
                self._roads[lane] = self._split(lane)
        self._single = [lane for lane in file.lanes if not self._roads.get(lane)]
        self._middles = {end for lane in self._single for end in (lane.start, lane.end)} & self._ends
        """Crossings that a single track begins in."""
        self._arms = self._find_arms()
        self._part = {node: node for node in self._ends}
        """Nodes that are one crossing lead to one another, and in the end to the same."""

    def layout(self) -> Layout:
        """All of it."""
        inner: dict[str, str] = {}
        for lane in self._file.lanes:
            self._set_stops(lane)
        order = [node.id for node in self._file.nodes if node.id in self._ends]
        first: dict[str, str] = {}
        for node in order:
            first.setdefault(self._root(node), node)
        crossing_of = {node: first[self._root(node)] for node in order}
        inner.update((node, crossing_of[node]) for node in order if node in self._middles)
        for road in self._all_roads():
            if crossing_of[road.start] == crossing_of[road.end]:
                inner.update((stop.id, crossing_of[road.start]) for stop in road.stops)
        lanes, crossed = self._lanes(crossing_of)
        nodes = (
            *(node for node in self._file.nodes if node.id not in self._ends or node.id in self._middles),
            *(stop for road in self._all_roads() for stop in road.stops),
        )
        return Layout(nodes, lanes, self._crossings(crossing_of, lanes, crossed, inner), inner, crossed)

    # --- where vehicles stop ----------------------------------------------------------------------

    def _split(self, lane: Lane) -> tuple[Road, ...]:
        """The directions of a lane between two crossings; none for a single track that is driven both ways or has a shape."""
        limit_mps = lane.speed_limit_mps
        if (lane.start, lane.end) in self._wide:
            offset_m = self._size.offset_m
            return (
                Road(lane.start, lane.end, limit_mps, offset_m, types=lane.types),
                Road(lane.end, lane.start, limit_mps, offset_m, types=lane.types),
            )
        if lane.both_ways or lane.shape:
            return ()
        return (Road(lane.start, lane.end, limit_mps, 0.0, types=lane.types),)

    def _find_arms(self) -> dict[str, list[tuple[float, float]]]:
        """The arms of each crossing's node: direction (rad) and half of the width that vehicles take there (m)."""
        half_m = self._size.width_m / 2.0
        arms: dict[str, list[tuple[float, float]]] = {node: [] for node in self._ends}
        for lane in self._file.lanes:
            wide = (lane.start, lane.end) in self._wide
            for here, there in ((lane.start, lane.end), (lane.end, lane.start)):
                if here in self._ends:
                    reach_m = half_m + (self._size.offset_m if wide else 0.0)
                    arms[here].append((self._heading_rad(here, there), reach_m))
        return arms

    def _clear_m(self, node: str, other: str) -> float:
        """Distance from a node to the stop point on the road to another, at which a vehicle is clear of all that cross."""
        size = self._size
        ahead_rad = self._heading_rad(node, other)
        own_m = next(reach_m for rad, reach_m in self._arms[node] if rad == ahead_rad)
        front_m = size.turning_radius_m if node in self._middles else 0.0
        for rad, reach_m in self._arms[node]:
            angle = abs((rad - ahead_rad + pi) % (2.0 * pi) - pi)
            if 1e-3 < angle < pi - 1e-3:
                # The inner corner of a vehicle that stands must be beyond the outer edge of the other road.
                front_m = max(front_m, (reach_m + own_m * cos(angle)) / sin(angle))
        return front_m + size.length_m / 2.0 + MARGIN_M

    def _set_stops(self, lane: Lane) -> None:
        """Give the directions of a lane their stop points; where there is no room, its crossings become one."""
        if lane.start not in self._ends or lane.end not in self._ends:
            return
        roads = self._roads[lane]
        if not roads:
            self._part[self._root(lane.start)] = self._root(lane.end)
            return
        length_m = self._length_m(lane.start, lane.end)
        for road in roads:
            after_m = self._clear_m(road.start, road.end)
            before_m = length_m - self._clear_m(road.end, road.start)
            if before_m - after_m >= self._size.spacing_m - 1e-9:
                road.stops = (
                    self._stop(road, name_after(road.start, road.end), after_m),
                    self._stop(road, name_before(road.start, road.end), before_m),
                )
                continue
            if before_m < after_m - 1e-9:
                self._part[self._root(lane.start)] = self._root(lane.end)
                after_m = before_m = length_m / 2.0
            middle_m = (after_m + before_m) / 2.0
            road.stops = (self._stop(road, name_after(road.start, road.end), middle_m),)

    def _stop(self, road: Road, name: str, along_m: float) -> Node:
        start, heading_rad = self._points[road.start], self._heading_rad(road.start, road.end)
        ahead_x, ahead_y = cos(heading_rad), sin(heading_rad)
        return Node(
            name,
            round(start.x_m + along_m * ahead_x + road.offset_m * ahead_y, 3),
            round(start.y_m + along_m * ahead_y - road.offset_m * ahead_x, 3),
        )

    # --- how they are joined ------------------------------------------------------------------------

    def _lanes(self, crossing_of: Mapping[str, str]) -> tuple[tuple[Lane, ...], dict[tuple[str, str], str]]:
        """Lanes between stop points, single tracks, and ways over crossings; and the crossing of each."""
        lanes: list[Lane] = []
        crossed: dict[tuple[str, str], str] = {}
        into: dict[str, list[tuple[Road, str]]] = {node: [] for node in crossing_of}
        out_of: dict[str, list[tuple[Road, str]]] = {node: [] for node in crossing_of}
        for lane in self._file.lanes:
            roads = self._roads.get(lane)
            if not roads:
                lanes.append(lane)
                for ends in _both((lane,)):
                    touched = next((crossing_of[end] for end in ends if end in crossing_of), None)
                    if touched is not None:
                        crossed[ends] = touched
                continue
            for road in roads:
                out_of[road.start].append((road, road.stops[0].id))
                into[road.end].append((road, road.stops[-1].id))
                lanes += [road.lane(a.id, b.id) for a, b in pairwise(road.stops)]
        for node, crossing in crossing_of.items():
            # Back where it came from, too: a vehicle may turn round.
            over = [
                way
                for entered, before in into[node]
                for left, after in out_of[node]
                if (way := over_crossing(entered, before, left, after)) is not None
            ]
            if node in self._middles:
                over += [road.lane(before, node) for road, before in into[node]]
                over += [road.lane(node, after) for road, after in out_of[node]]
            lanes += over
            crossed.update(((lane.start, lane.end), crossing) for lane in over)
        return tuple(lanes), crossed

    def _crossings(
        self,
        crossing_of: Mapping[str, str],
        lanes: Iterable[Lane],
        crossed: Mapping[tuple[str, str], str],
        inner: Mapping[str, str],
    ) -> dict[str, Crossing]:
        nodes: dict[str, list[str]] = {}
        for node, crossing in crossing_of.items():
            nodes.setdefault(crossing, []).append(node)
        entries: dict[str, dict[str, None]] = {crossing: {} for crossing in nodes}
        exits: dict[str, dict[str, None]] = {crossing: {} for crossing in nodes}
        touching: dict[str, list[tuple[str, str]]] = {crossing: [] for crossing in nodes}
        for ends in _both(lanes):
            if (touched := crossed.get(ends)) is not None:
                touching[touched].append(ends)
                if ends[0] not in inner:
                    entries[touched][ends[0]] = None
                if ends[1] not in inner:
                    exits[touched][ends[1]] = None
        return {
            crossing: Crossing(
                crossing,
                tuple(members),
                sum(self._points[node].x_m for node in members) / len(members),
                sum(self._points[node].y_m for node in members) / len(members),
                tuple(entries[crossing]),
                tuple(exits[crossing]),
                tuple(touching[crossing]),
                tuple(node for node, at in inner.items() if at == crossing),
            )
            for crossing, members in nodes.items()
        }

    # --- small things --------------------------------------------------------------------------------

    def _all_roads(self) -> Iterable[Road]:
        return (road for roads in self._roads.values() for road in roads)

    def _root(self, node: str) -> str:
        while (above := self._part[node]) != node:
            # What hangs together may be as long as the floor: each look halves the way for the next one.
            self._part[node] = node = self._part[above]
        return node

    def _heading_rad(self, start: str, end: str) -> float:
        a, b = self._points[start], self._points[end]
        return atan2(b.y_m - a.y_m, b.x_m - a.x_m)

    def _length_m(self, start: str, end: str) -> float:
        a, b = self._points[start], self._points[end]
        return hypot(b.x_m - a.x_m, b.y_m - a.y_m)
