"""Where a floor is too narrow for its vehicles: warnings about places, lanes and crossings.

Two vehicles at places that are too near to one another touch; so does one that stands beside a lane and one that drives there. All
of it is asked of the largest vehicle of the plant, in every direction in which it can stand at a place.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import product
from math import floor, hypot, pi
from typing import TypeVar

from dray.plant.floor.rectangles import Rectangle, driven, gap_m, standing
from dray.plant.layout import Size
from dray.plant.plant import Plant
from dray.plant.roads import DirectedLane

T = TypeVar("T")

Subject = tuple[str, ...]
"""What a warning is about: nodes, by their ids."""

Finding = tuple[str, str, str, tuple[Subject, ...]]
"""Kind, section of the file, text, and all that it is about, in the order of the text."""

SHOWN = 3
"""Examples in one warning."""

TOUCH_M = 1e-3
"""Rectangles that only touch do not overlap."""


def floor_advice(plant: Plant) -> Iterator[Finding]:
    """All that is too narrow, as (kind, section, text, subjects)."""
    room = _Room(plant)
    yield from room.places()
    yield from room.beside_lanes()
    yield from room.meeting_lanes()
    yield from _merged(plant)
    yield from _docks_in_the_way(plant)
    yield from _no_turning(plant)


def _listed(found: list[str]) -> str:
    more = f" and {len(found) - SHOWN} more" if len(found) > SHOWN else ""
    return f"{', '.join(found[:SHOWN])}{more}"


class _Room:
    """Where vehicles stand and drive, sorted by where that is."""

    def __init__(self, plant: Plant) -> None:
        self._plant = plant
        self._size = size = Size.of(plant.vehicle_types.values())
        self._reach_m = size.length_m + size.turning_radius_m
        self._stands = {node: tuple(self._standing(node)) for node in plant.stops}

    def places(self) -> Iterator[Finding]:
        """Pairs of places where vehicles that stand touch one another."""
        cells: dict[tuple[int, int], list[str]] = {}
        found: dict[Subject, str] = {}
        for node, stands in self._stands.items():
            here = self._plant.nodes[node]
            for other in self._near(cells, here.x_m, here.y_m):
                if any(gap_m(a, b) < -TOUCH_M for a, b in product(stands, self._stands[other])):
                    there = self._plant.nodes[other]
                    away_m = hypot(here.x_m - there.x_m, here.y_m - there.y_m)
                    found[other, node] = f"{other} and {node} ({away_m:.2f} m)"
            cells.setdefault(self._cell(here.x_m, here.y_m), []).append(node)
        if found:
            text = (
                f"{_listed(list(found.values()))} are nearer to one another than vehicles of {self._size.length_m:g} m x "
                f"{self._size.width_m:g} m can stand: move them apart, or make them one node"
            )
            yield "near", "nodes", text, tuple(found)

    def beside_lanes(self) -> Iterator[Finding]:
        """Places where a vehicle stands in the way of one that drives past."""
        cells: dict[tuple[int, int], list[str]] = {}
        for node in self._stands:
            here = self._plant.nodes[node]
            cells.setdefault(self._cell(here.x_m, here.y_m), []).append(node)
        found: dict[str, DirectedLane] = {}
        size, nodes = self._size, self._plant.nodes
        for lane in self._plant.lanes:
            ends = (lane.start, lane.end)
            swept = driven(nodes[lane.start], nodes[lane.end], size.length_m, size.width_m)
            for node in self._along(cells, lane):
                if node not in ends and node not in found and self._touches(node, swept):
                    found[node] = lane
        if found:
            told = [f"{node} (from {lane.start} to {lane.end})" for node, lane in found.items()]
            text = f"who stands at {_listed(told)} is in the way of whoever drives past: move the place or the lane away"
            yield "narrow", "nodes", text, tuple((node, lane.start, lane.end) for node, lane in found.items())

    def meeting_lanes(self) -> Iterator[Finding]:
        """Lanes that cross or touch without a common node: right of way knows lanes by their nodes alone."""
        plant, size = self._plant, self._size
        bent = {corner: ends for ends, chain in plant.corners.items() for corner in chain}
        cells: dict[tuple[int, int], list[int]] = {}
        swept: list[tuple[frozenset[str], frozenset[str], Rectangle]] = []
        found: dict[frozenset[frozenset[str]], str] = {}
        driven_over: set[frozenset[str]] = set()
        for lane in plant.lanes:
            both = frozenset((lane.start, lane.end))
            if both in driven_over:
                continue  # The way back.
            driven_over.add(both)
            ends = bent.get(lane.start) or bent.get(lane.end) or (lane.start, lane.end)
            whole, places = frozenset(ends), frozenset(plant.places_on(lane.start, lane.end))
            area = driven(plant.nodes[lane.start], plant.nodes[lane.end], 0.0, size.width_m)
            for index in self._along(cells, lane):
                other, taken, there = swept[index]
                pair = frozenset((whole, other))
                if pair not in found and not whole & other and not places & taken:
                    if gap_m(area, there) < -TOUCH_M:
                        found[pair] = f"{' to '.join(sorted(other))} and {' to '.join(sorted(whole))}"
            swept.append((whole, places, area))
            for cell in self._cells_of(lane):
                cells.setdefault(cell, []).append(len(swept) - 1)
        if found:
            text = (
                f"lanes cross or touch without a common node: {_listed(list(found.values()))}; vehicles on them are not kept apart: "
                "give them a node where they meet, or move them apart"
            )
            yield (
                "touch",
                "lanes",
                text,
                tuple(tuple(sorted(map("--".join, map(sorted, pair)))) for pair in found),
            )

    def _touches(self, node: str, swept: Rectangle) -> bool:
        return any(gap_m(stand, swept) < -TOUCH_M for stand in self._stands[node])

    def _standing(self, node: str) -> Iterator[Rectangle]:
        """In every direction in which one comes or sets off; forwards and backwards are the same."""
        roads, size = self._plant.roads, self._size
        headings = {round(lane.heading_rad % pi, 6) for lane in (*roads.entering[node], *roads.leaving[node])}
        for heading_rad in sorted(headings):
            yield standing(self._plant.nodes[node], heading_rad, size.length_m, size.width_m)

    # --- what is near -------------------------------------------------------------------------------

    def _cell(self, x_m: float, y_m: float) -> tuple[int, int]:
        return floor(x_m / self._reach_m), floor(y_m / self._reach_m)

    def _near(self, cells: dict[tuple[int, int], list[T]], x_m: float, y_m: float) -> Iterator[T]:
        column, row = self._cell(x_m, y_m)
        for x, y in product(range(column - 1, column + 2), range(row - 1, row + 2)):
            yield from cells.get((x, y), ())

    def _along(self, cells: dict[tuple[int, int], list[T]], lane: DirectedLane) -> Iterable[T]:
        """What lies near a lane; nothing that could touch it is missing."""
        near: dict[T, None] = {}
        for x_m, y_m in self._points_on(lane):
            near.update(dict.fromkeys(self._near(cells, x_m, y_m)))
        return near

    def _cells_of(self, lane: DirectedLane) -> Iterable[tuple[int, int]]:
        """Where a lane lies; what looks for it looks in the cells around, too."""
        return dict.fromkeys(self._cell(x_m, y_m) for x_m, y_m in self._points_on(lane))

    def _points_on(self, lane: DirectedLane) -> Iterator[tuple[float, float]]:
        """Points of a lane, so near to one another that each cell around it is met."""
        start, end = self._plant.nodes[lane.start], self._plant.nodes[lane.end]
        steps = max(1, int(lane.length_m / self._reach_m) + 1)
        for step in range(steps + 1):
            part = step / steps
            yield start.x_m + part * (end.x_m - start.x_m), start.y_m + part * (end.y_m - start.y_m)


def _merged(plant: Plant) -> Iterator[Finding]:
    """Two-lane roads without a stop point between two crossings: they are crossed, and waited for, as one."""
    found = [crossing for crossing in plant.crossings.values() if len(crossing.nodes) > 1]
    if found:
        told = _listed([" and ".join(crossing.nodes) for crossing in found])
        text = (
            f"there is no room for a stop point between {told}: each is one crossing for one vehicle at a time; "
            "move them apart, or make them one node"
        )
        yield "crossing", "lanes", text, tuple(crossing.nodes for crossing in found)


def _docks_in_the_way(plant: Plant) -> Iterator[Finding]:
    """Docks in the only way to others: while a vehicle stands there nobody passes."""
    docks = dict.fromkeys(plant.node_of(place) for place in plant.places)
    found = []
    for dock in docks:
        beside = {lane.end for lane in plant.roads.leaving[dock]} | {
            lane.start for lane in plant.roads.entering[dock]
        }
        if len(beside) > 1 and not _is_open(plant, dock, docks):
            found.append(dock)
    if found:
        text = f"vehicles dock at {_listed(found)} in the only way to others, who wait for them: give each dock a spur"
        yield "way", "nodes", text, tuple((dock,) for dock in found)


def _no_turning(plant: Plant) -> Iterator[Finding]:
    """Doors before which no lane leads back: whoever stands there when one fails has to wait for people."""
    roads = plant.roads
    found = {
        (start, end): f"{door.name} at {start}"
        for (start, end), door in plant.door_on.items()
        if all(lane.end == end for lane in roads.leaving[start])
    }
    if found:
        text = (
            f"no lane leads back from before {_listed(list(found.values()))}: who stands there when the door does not open waits for "
            "people; on a single track with another lane at its node it turns by itself"
        )
        yield "door", "doors", text, tuple(found)


def _is_open(plant: Plant, blocked: str, docks: Iterable[str]) -> bool:
    """Whether all other docks still reach one another while a node is blocked."""
    others = [dock for dock in docks if dock != blocked]
    if not others:
        return True
    roads = plant.roads
    return set(others) <= roads.reached_from(others[0], blocked) and set(others) <= roads.reaching(
        others[0], blocked
    )
