"""Repairs for errors of a draft: one change each, with a measure that people see before they accept it.

Repairs for warnings are in `dray.gateway.factory.floor_repairs`. A repair is offered only after a test: the
error is gone, and no new one has come.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from itertools import islice
from math import hypot
from typing import Any

import msgspec
from msgspec.structs import replace

from dray.plant.file.check_floor import floor_faults
from dray.plant.file.unfinished import drawable
from dray.plant.model import Box, Lane, Node, PlantFile

SPEED_MPS = 1.5
"""Speed limit of a proposed lane; people can change it."""

TRIED = 4
"""Maximum changes tried per finding."""

MAX_REPAIRS = 5
"""Maximum repairs sought per draft, since each try checks the whole floor; once these findings are solved,
others get theirs."""

FIELD = re.compile(r"^(\w+)\[(\d+)\](?:\.(\w+))?$")

DOCKS = frozenset({"machines", "storages", "warehouses", "chargers", "parkings"})


class Spot(msgspec.Struct, frozen=True):
    """A point of the floor."""

    x_m: float
    y_m: float


class MovedAlong(msgspec.Struct, frozen=True):
    """A node that moves along with another one."""

    index: int
    """Index of the changed entry."""
    entry: dict[str, Any]
    """Fields to set in the entry."""


class RepairView(msgspec.Struct, frozen=True, kw_only=True):
    """One change that solves a finding, tested before it is offered."""

    kind: str
    """move (onto the floor), shift (a node, so that vehicles have room), join (a new two-way lane), back
    (make a lane two-way), drop (the second of two lanes), or stand (a vehicle begins elsewhere)."""
    section: str
    index: int | None
    """Index of the changed entry; null for a new one at the end."""
    entry: dict[str, Any] | None
    """Fields to set in the entry; null to remove it."""
    name: str
    """The place or node concerned."""
    distance_m: float
    """Length of the shift or lane."""
    measure: tuple[Spot, ...]
    """Ends of that shift or lane."""
    also: tuple[MovedAlong, ...] = ()
    """Other entries changed with it: nodes of roads across, moved as far."""


class Repairs:
    """The repairs of one draft.

    Args:
        data: the draft's plant file.
    """

    def __init__(self, data: Mapping[str, object]) -> None:
        file = drawable(data)[1]
        self._file = file
        self._faults = frozenset(() if file is None else floor_faults(file))
        self._sought: set[str] = set()

    def of(self, field: str, reason: str) -> RepairView | None:
        """A repair of an error; None when nothing tried helps."""
        found = FIELD.match(field)
        if self._file is None or found is None or (field, reason) not in self._faults:
            return None
        if field in self._sought or len(self._sought) == MAX_REPAIRS:
            return None
        self._sought.add(field)
        before = {where for where, _ in self._faults}
        proposals = _Proposals(self._file).of(found[1], int(found[2]), found[3] or "")
        for repair, file in islice(proposals, TRIED):
            after = {where for where, _ in floor_faults(file)}
            if field not in after and after < before:
                return repair
        return None


class _Proposals:
    """Changes that may solve an error, the smallest first."""

    def __init__(self, file: PlantFile) -> None:
        self._file = file
        self._nodes = {node.id: node for node in file.nodes}

    def of(self, section: str, index: int, part: str) -> Iterator[tuple[RepairView, PlantFile]]:
        if section == "lanes" and not part:
            yield from self._drop(index)
        elif section == "nodes" and not part:
            yield from self._move_node(index)
        elif section in DOCKS and part == "box":
            yield from self._move_box(section, index)
        elif section == "fleet" and part == "node":
            yield from self._stand(index)
        elif section in DOCKS and part == "node":
            place = getattr(self._file, section)[index]
            if (node := self._nodes.get(place.node)) is not None:
                yield from self._back(place.id, node)
                yield from self._join(place.id, node)

    def _drop(self, index: int) -> Iterator[tuple[RepairView, PlantFile]]:
        lane = self._file.lanes[index]
        start, end = self._nodes.get(lane.start), self._nodes.get(lane.end)
        if start is not None and end is not None:
            lanes = self._file.lanes[:index] + self._file.lanes[index + 1 :]
            name = f"{lane.start} to {lane.end}"
            yield self._view("drop", "lanes", index, None, name, start, end), replace(self._file, lanes=lanes)

    def _move_node(self, index: int) -> Iterator[tuple[RepairView, PlantFile]]:
        node = self._file.nodes[index]
        moved = Node(
            id=node.id,
            x_m=min(max(node.x_m, 0.0), self._file.width_m),
            y_m=min(max(node.y_m, 0.0), self._file.height_m),
        )
        entry = {"x_m": moved.x_m, "y_m": moved.y_m}
        nodes = _with(self._file.nodes, index, moved)
        yield (
            self._view("move", "nodes", index, entry, node.id, node, moved),
            replace(self._file, nodes=nodes),
        )

    def _move_box(self, section: str, index: int) -> Iterator[tuple[RepairView, PlantFile]]:
        place = getattr(self._file, section)[index]
        box: Box = place.box
        half_x_m, half_y_m = box.width_m / 2, box.depth_m / 2
        moved = replace(
            box,
            x_m=min(max(box.x_m, half_x_m), self._file.width_m - half_x_m),
            y_m=min(max(box.y_m, half_y_m), self._file.height_m - half_y_m),
        )
        entry = {"box": msgspec.to_builtins(moved)}
        places = _with(getattr(self._file, section), index, replace(place, box=moved))
        view = self._view("move", section, index, entry, place.id, box, moved)
        yield view, replace(self._file, **{section: places})

    def _back(self, name: str, node: Node) -> Iterator[tuple[RepairView, PlantFile]]:
        """Make a lane at this node two-way."""
        for index, lane in enumerate(self._file.lanes):
            if lane.both_ways or node.id not in (lane.start, lane.end):
                continue
            lanes = _with(self._file.lanes, index, replace(lane, both_ways=True))
            view = self._view(
                "back",
                "lanes",
                index,
                {"both_ways": True},
                name,
                self._nodes[lane.start],
                self._nodes[lane.end],
            )
            yield view, replace(self._file, lanes=lanes)

    def _join(self, name: str, node: Node) -> Iterator[tuple[RepairView, PlantFile]]:
        """Add a lane to one of the nearest nodes."""
        others = [other for other in self._file.nodes if other.id != node.id]
        for other in sorted(others, key=lambda each: _away_m(node, each)):
            lane = Lane(start=other.id, end=node.id, speed_limit_mps=SPEED_MPS, both_ways=True)
            entry = {
                "start": lane.start,
                "end": lane.end,
                "speed_limit_mps": SPEED_MPS,
                "both_ways": True,
            }
            view = self._view("join", "lanes", None, entry, name, other, node)
            yield view, replace(self._file, lanes=(*self._file.lanes, lane))

    def _stand(self, index: int) -> Iterator[tuple[RepairView, PlantFile]]:
        """Choose another start for a vehicle."""
        vehicle = self._file.fleet[index]
        here = self._nodes.get(vehicle.node)
        if here is None:
            return
        taken = {other.node for other in self._file.fleet}
        stands = [
            *(place.node for place in self._file.parkings),
            *(place.node for place in self._file.chargers),
        ]
        free = [self._nodes[stand] for stand in stands if stand in self._nodes and stand not in taken]
        for node in sorted(free, key=lambda each: _away_m(here, each)):
            fleet = _with(self._file.fleet, index, replace(vehicle, node=node.id))
            view = self._view("stand", "fleet", index, {"node": node.id}, vehicle.id, here, node)
            yield view, replace(self._file, fleet=fleet)

    @staticmethod
    def _view(
        kind: str,
        section: str,
        index: int | None,
        entry: dict[str, Any] | None,
        name: str,
        start: Node | Box,
        end: Node | Box,
    ) -> RepairView:
        return RepairView(
            kind=kind,
            section=section,
            index=index,
            entry=entry,
            name=name,
            distance_m=round(_away_m(start, end), 2),
            measure=(Spot(start.x_m, start.y_m), Spot(end.x_m, end.y_m)),
        )


def _away_m(one: Node | Box, other: Node | Box) -> float:
    return hypot(one.x_m - other.x_m, one.y_m - other.y_m)


def _with(entries: tuple[Any, ...], index: int, entry: Any) -> tuple[Any, ...]:
    return (*entries[:index], entry, *entries[index + 1 :])
