"""Whether two vehicles have room wherever right of way lets both in: at two places, or at a place and on a lane past it.

A vehicle holds the place at which it stands, and on a lane the places that the lane needs (`Plant.places_on`). When
it sets off it may turn on the spot, with the places of that lane. So two vehicles may be in these positions:

- each stands at its place, and one of them, or both, turn: unless the turn needs the other's place (`near`);
- one stands or turns at a place while the other drives a lane that does not end there, or turns at a node without a
  place (`narrow`);
- they are on two lanes that have no place in common (`touch`).

Each case is checked with the rectangles of the possible types, and with `CLEARANCE_M` between them. All directions
count in which a vehicle comes, sets off or begins the day. A finding is an error: vehicles would be in one spot
although all keep the rules.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import product
from math import ceil, floor, hypot, pi
from typing import NamedTuple, TypeVar

from dray.plant.file.reasons import Reason, listed
from dray.plant.floor.clearance import (
    CLEARANCE_M,
    SAME_RAD,
    clear_m,
    turn_rad,
    turning_gap_m,
)
from dray.plant.floor.rectangles import Rectangle, driven, gap_m
from dray.plant.layout import MARGIN_M, Size
from dray.plant.model import Node
from dray.plant.plant import Plant
from dray.plant.roads import DirectedLane

T = TypeVar("T")

Subject = tuple[str, ...]
"""Nodes of a finding, by their ids."""

Finding = tuple[str, str, Reason, tuple[Subject, ...]]
"""Kind, section of the file, text, and all that it is about, in the order of the text."""

ERRORS = frozenset({"near", "narrow", "touch"})
"""The kinds that are errors."""

SAME_M = 1e-6
"""Distances that differ by less are the same."""

START_RAD = 0.0
"""The direction of a vehicle that has not driven yet."""


class Turn(NamedTuple):
    """A turn on the spot, from one direction to another, with the places that are held for it."""

    before_rad: float
    after_rad: float
    needs: frozenset[str]


def room_faults(plant: Plant) -> Iterator[Finding]:
    """Pairs of vehicles without room, as (kind, section, text, subjects)."""
    room = Room(plant)
    yield from room.places()
    yield from room.beside_lanes()
    yield from room.meeting_lanes()


class Room:
    """The areas of vehicles that stand, turn and drive, sorted by position.

    Args:
        plant: without faults.
    """

    def __init__(self, plant: Plant) -> None:
        self._plant = plant
        kinds = plant.vehicle_types
        whole = Size.of(kinds.values())
        self._reach_m = whole.length_m + whole.turning_radius_m + MARGIN_M
        starts: dict[str, set[str]] = {}
        for spec in plant.fleet.values():
            starts.setdefault(spec.node, set()).add(spec.type)
        self._sizes: dict[frozenset[str], Size] = {}
        self._size_at: dict[str, Size] = {}
        self._headings: dict[str, tuple[float, ...]] = {}
        self._turns: dict[str, tuple[Turn, ...]] = {}
        for node in plant.nodes:
            entering, leaving = plant.roads.entering[node], plant.roads.leaving[node]
            coming = frozenset(self._kinds(lane) for lane in (*entering, *leaving))
            come = frozenset[str]().union(*coming, starts.get(node, ()))
            if not come:
                continue  # No vehicle comes there.
            self._size_at[node] = self._size(come)
            begins = {START_RAD} if node in starts else set()
            before = sorted({round(lane.heading_rad, 9) for lane in entering} | begins)
            self._headings[node] = tuple(sorted({*before, *(round(lane.heading_rad, 9) for lane in leaving)}))
            self._turns[node] = tuple(
                Turn(heading, lane.heading_rad, frozenset(plant.places_on(lane.start, lane.end)))
                for lane in leaving
                for heading in before
                if abs(turn_rad(heading, lane.heading_rad)) > SAME_RAD
            )
        self._stops = tuple(node for node in plant.stops if node in self._size_at)

    # --- what is found ------------------------------------------------------------------------------

    def places(self) -> Iterator[Finding]:
        """Pairs of places where vehicles touch that stand or turn there."""
        found: dict[Subject, Reason] = {}
        cells: dict[tuple[int, int], list[str]] = {}
        for node in self._stops:
            here = self._plant.nodes[node]
            for other in self._near(cells, here.x_m, here.y_m):
                there = self._plant.nodes[other]
                short_m = CLEARANCE_M - self.apart_m(node, other)
                if short_m > 0.0:
                    away_m = hypot(here.x_m - there.x_m, here.y_m - there.y_m)
                    needed_m = ceil((away_m + short_m) * 100.0 - 1e-6) / 100.0
                    found[other, node] = Reason(
                        "pair_room", one=other, other=node, away_m=away_m, needed_m=needed_m
                    )
            cells.setdefault(self._cell(here.x_m, here.y_m), []).append(node)
        if found:
            size = self._largest(node for pair in found for node in pair)
            text = Reason(
                "near", pairs=listed(list(found.values())), length_m=size.length_m, width_m=size.width_m
            )
            yield "near", "nodes", text, tuple(found)

    def beside_lanes(self) -> Iterator[Finding]:
        """Places where a vehicle is in the way of a passing one."""
        cells: dict[tuple[int, int], list[str]] = {}
        for node in self._stops:
            here = self._plant.nodes[node]
            cells.setdefault(self._cell(here.x_m, here.y_m), []).append(node)
        found: dict[str, tuple[DirectedLane, float]] = {}
        for lane in self._plant.lanes:
            for node in self._along(cells, lane):
                if node in (lane.start, lane.end):
                    continue
                short_m = CLEARANCE_M - self.beside_m(node, lane)
                if short_m > (found[node][1] + SAME_M if node in found else 0.0):
                    found[node] = (lane, short_m)
        if found:
            told = [
                Reason(
                    "beside_lane",
                    node=node,
                    start=lane.start,
                    end=lane.end,
                    short_m=ceil(short_m * 100.0 - 1e-6) / 100.0,
                )
                for node, (lane, short_m) in found.items()
            ]
            text = Reason("narrow", places=listed(told))
            subjects = tuple((node, lane.start, lane.end) for node, (lane, _) in found.items())
            yield "narrow", "nodes", text, subjects

    def meeting_lanes(self) -> Iterator[Finding]:
        """Lanes that cross or touch: right of way knows lanes by their nodes alone."""
        plant = self._plant
        chain_of = {corner: ends for ends, chain in plant.corners.items() for corner in chain}
        cells: dict[tuple[int, int], list[int]] = {}
        pieces: list[tuple[DirectedLane, frozenset[str], frozenset[str]]] = []
        found: dict[frozenset[frozenset[str]], Reason] = {}
        driven_over: set[frozenset[str]] = set()
        for lane in plant.lanes:
            both = frozenset((lane.start, lane.end))
            if both in driven_over:
                continue  # The way back.
            driven_over.add(both)
            ends = chain_of.get(lane.start) or chain_of.get(lane.end) or (lane.start, lane.end)
            whole = frozenset(ends)
            places = frozenset(
                place
                for way in ((lane.start, lane.end), (lane.end, lane.start))
                if plant.roads.lane(*way) is not None
                for place in plant.places_on(*way)
            )
            crossed = frozenset(place for place in places if place in plant.crossings)
            for index in self._along(cells, lane):
                against, other, taken = pieces[index]
                pair = frozenset((whole, other))
                if len(pair) < 2 or pair in found or crossed & taken:
                    continue
                if self._meet(lane, whole, against, other):
                    found[pair] = Reason("and", one=_road(other), other=_road(whole))
            pieces.append((lane, whole, crossed))
            for cell in self._cells_of(lane):
                cells.setdefault(cell, []).append(len(pieces) - 1)
        if found:
            text = Reason("touch", pairs=listed(list(found.values())))
            subjects = tuple(tuple(sorted(map("--".join, map(sorted, pair)))) for pair in found)
            yield "touch", "lanes", text, subjects

    # --- how far vehicles are apart -------------------------------------------------------------------

    def apart_m(self, one: str, other: str) -> float:
        """Smallest gap between vehicles at two places; below 0 the depth of their overlap."""
        plant = self._plant
        here, there = plant.nodes[one], plant.nodes[other]
        first, second = self._size_at[one], self._size_at[other]
        circles_m = (
            hypot(here.x_m - there.x_m, here.y_m - there.y_m)
            - first.turning_radius_m
            - second.turning_radius_m
        )
        if circles_m >= CLEARANCE_M:
            return circles_m
        turns = [turn for turn in self._turns[one] if other not in turn.needs]
        others = [turn for turn in self._turns[other] if one not in turn.needs]
        if any(not turn.needs & against.needs for turn in turns for against in others):
            return circles_m
        stands = [first.at(here, heading) for heading in self._headings[one]]
        against = [second.at(there, heading) for heading in self._headings[other]]
        return min(
            (
                *(gap_m(a, b) for a, b in product(stands, against)),
                *self._turning(one, turns, against),
                *self._turning(other, others, stands),
            ),
            default=float("inf"),
        )

    def beside_m(self, node: str, lane: DirectedLane) -> float:
        """Gap between a vehicle at a place and one that drives a lane past it, or turns where it ends."""
        plant = self._plant
        here, own = plant.nodes[node], self._size_at[node]
        start, end = plant.nodes[lane.start], plant.nodes[lane.end]
        size = self._size(self._kinds(lane))
        needs = frozenset(plant.places_on(lane.start, lane.end))
        swept = driven(start, end, size.length_m, size.width_m)
        stands = [own.at(here, heading) for heading in self._headings[node]]
        gaps = [gap_m(stand, swept) for stand in stands]
        left = plant.crossing_of(lane.start) or lane.start
        for turn in self._turns[node]:
            if turn.needs & needs:
                continue
            past = swept if left not in turn.needs else _past(start, end, lane.length_m, size)
            if past is not None:
                gaps.extend(self._turning(node, (turn,), (past,)))
        if lane.end in plant.nodes and plant.crossing_of(lane.end):
            gaps.extend(self._turning(lane.end, self._passing_turns(lane, node), stands))
        return min(gaps)

    def _passing_turns(self, lane: DirectedLane, beside: str) -> list[Turn]:
        """Turns of a vehicle that has driven a lane to a node without a place, and goes on past a place."""
        roads = self._plant.roads
        return [
            Turn(lane.heading_rad, onward.heading_rad, frozenset())
            for onward in roads.leaving[lane.end]
            if onward.end != beside and abs(turn_rad(lane.heading_rad, onward.heading_rad)) > SAME_RAD
        ]

    def _turning(self, node: str, turns: Iterable[Turn], others: Iterable[Rectangle]) -> Iterator[float]:
        spot, size = self._plant.nodes[node], self._size_at[node]
        near = [each for each in others if _from_point_m(spot, each) - size.turning_radius_m < CLEARANCE_M]
        for turn, other in product(turns, near):
            yield turning_gap_m(size, spot, turn.before_rad, turn.after_rad, other)

    def _meet(
        self, lane: DirectedLane, whole: frozenset[str], against: DirectedLane, other: frozenset[str]
    ) -> bool:
        """Whether vehicles on two lanes could touch; near a common end, they hold that in turn."""
        common = whole & other
        size, second = self._size(self._kinds(lane)), self._size(self._kinds(against))
        if not common:
            return (
                gap_m(
                    self._strip(lane, size.width_m, 0.0, lane.length_m),
                    self._strip(against, second.width_m, 0.0, against.length_m),
                )
                < CLEARANCE_M
            )
        if len(common) > 1:
            return False
        return self._side_by_side(next(iter(common)), lane, against, size) or self._side_by_side(
            next(iter(common)), against, lane, second
        )

    def _side_by_side(self, node: str, left: DirectedLane, other: DirectedLane, size: Size) -> bool:
        """Whether a vehicle that has left a node, and given it back, touches one that comes from there or goes there."""
        out = left if left.start == node else self._plant.roads.lane(left.end, left.start)
        if out is None or out.start != node or node not in (other.start, other.end):
            return False
        away_rad = other.heading_rad if other.start == node else other.heading_rad + pi
        angle = abs(turn_rad(out.heading_rad, away_rad))
        whole = self._size(frozenset(self._plant.vehicle_types))
        from_m = clear_m(whole.length_m, whole.width_m, angle) - size.length_m / 2.0
        if from_m >= out.length_m:
            return False
        beside = self._size(self._kinds(other))
        return (
            gap_m(
                self._strip(out, size.width_m, from_m, out.length_m),
                self._strip(other, beside.width_m, 0.0, other.length_m),
            )
            < CLEARANCE_M
        )

    def _strip(self, lane: DirectedLane, width_m: float, from_m: float, to_m: float) -> Rectangle:
        """The area of a part of a lane, cut off at its ends."""
        start, end = self._plant.nodes[lane.start], self._plant.nodes[lane.end]
        middle = (from_m + to_m) / 2.0 / lane.length_m
        return Rectangle(
            start.x_m + middle * (end.x_m - start.x_m),
            start.y_m + middle * (end.y_m - start.y_m),
            lane.heading_rad,
            to_m - from_m,
            width_m,
        )

    # --- who comes there ------------------------------------------------------------------------------

    def _kinds(self, lane: DirectedLane) -> frozenset[str]:
        known = self._plant.vehicle_types
        own = frozenset(each.type for each in lane.types if each.type in known)
        return own or frozenset(known)

    def _size(self, kinds: frozenset[str]) -> Size:
        size = self._sizes.get(kinds)
        if size is None:
            known = self._plant.vehicle_types
            size = Size.of(known[kind] for kind in sorted(kinds))
            self._sizes[kinds] = size
        return size

    def _largest(self, nodes: Iterable[str]) -> Size:
        return max((self._size_at[node] for node in nodes), key=lambda size: (size.length_m, size.width_m))

    # --- what is near -------------------------------------------------------------------------------

    def _cell(self, x_m: float, y_m: float) -> tuple[int, int]:
        return floor(x_m / self._reach_m), floor(y_m / self._reach_m)

    def _near(self, cells: dict[tuple[int, int], list[T]], x_m: float, y_m: float) -> Iterator[T]:
        column, row = self._cell(x_m, y_m)
        for x, y in product(range(column - 1, column + 2), range(row - 1, row + 2)):
            yield from cells.get((x, y), ())

    def _along(self, cells: dict[tuple[int, int], list[T]], lane: DirectedLane) -> Iterable[T]:
        """All objects near a lane, at least those that could touch it."""
        near: dict[T, None] = {}
        for x_m, y_m in self._points_on(lane):
            near.update(dict.fromkeys(self._near(cells, x_m, y_m)))
        return near

    def _cells_of(self, lane: DirectedLane) -> Iterable[tuple[int, int]]:
        """Cells of a lane; a search also looks in the cells around."""
        return dict.fromkeys(self._cell(x_m, y_m) for x_m, y_m in self._points_on(lane))

    def _points_on(self, lane: DirectedLane) -> Iterator[tuple[float, float]]:
        """Points of a lane, so near to one another that each cell around it is met."""
        start, end = self._plant.nodes[lane.start], self._plant.nodes[lane.end]
        steps = max(1, int(lane.length_m / self._reach_m) + 1)
        for step in range(steps + 1):
            part = step / steps
            yield start.x_m + part * (end.x_m - start.x_m), start.y_m + part * (end.y_m - start.y_m)


def _road(ends: frozenset[str]) -> Reason:
    start, end = sorted(ends)
    return Reason("from_to", start=start, end=end)


def _past(start: Node, end: Node, length_m: float, size: Size) -> Rectangle | None:
    """The area of a vehicle on a lane after it has given back the place at its start.

    Returns None where the lane is too short.
    """
    spacing_m = size.spacing_m
    if spacing_m >= length_m:
        return None
    part = spacing_m / length_m
    from_m = Node(
        start.id, start.x_m + part * (end.x_m - start.x_m), start.y_m + part * (end.y_m - start.y_m)
    )
    return driven(from_m, end, size.length_m, size.width_m)


def _from_point_m(spot: Node, of: Rectangle) -> float:
    """Distance of a rectangle from a point, or less; below 0 for a point in it."""
    return gap_m(Rectangle(spot.x_m, spot.y_m, of.heading_rad, 0.0, 0.0), of)
