"""Faults of doors in a plant file: each stands on the lanes that it names, with room to wait before it."""

from __future__ import annotations

from collections.abc import Iterator

from dray.plant.file.reasons import Reason
from dray.plant.floor.doors import LEAF_M, Ends, driven_through, lanes_between, leaf_of
from dray.plant.floor.rectangles import driven, gap_m
from dray.plant.floor.shapes import joined_floor
from dray.plant.layout import MARGIN_M, Layout, Size
from dray.plant.model import Door, Lane, PlantFile
from dray.plant.roads import DirectedLane, Roads

Fault = tuple[str, str]
"""Field and reason."""


def door_faults(file: PlantFile) -> Iterator[Fault]:
    """Faults of doors, as (field, reason). Lanes with unknown ends are reported elsewhere."""
    if not file.doors:
        return
    lanes = lanes_between(file)
    owners: dict[Lane, str] = {}
    layout = joined_floor(file)
    roads = None if layout is None else Roads(layout.nodes, layout.lanes)
    for index, door in enumerate(file.doors):
        through: list[DirectedLane] = []
        faulty = False
        for at, named in enumerate(door.lanes):
            where = f"doors[{index}].lanes[{at}]"
            lane = lanes.get((named.start, named.end))
            if lane is None:
                faulty = True
                yield where, Reason("door_no_lane", start=named.start, end=named.end)
            elif lane in owners:
                faulty = True
                yield where, _twice(lane, owners[lane], door)
            else:
                owners[lane] = door.id
                if layout is not None and roads is not None:
                    found = list(_driven(lane, layout, roads))
                    through += found
                    reason = _cannot_stand(lane, found, layout, file)
                    faulty |= bool(reason)
                    if reason:
                        yield where, reason
        if layout is not None and roads is not None and not faulty and through:
            yield from _in_others_way(index, door, through, layout, roads, file)


def _twice(lane: Lane, owner: str, door: Door) -> str:
    if owner != door.id:
        return Reason("door_owned", owner=owner, start=lane.start, end=lane.end)
    return Reason("door_named_both" if lane.both_ways else "door_named", start=lane.start, end=lane.end)


def _driven(lane: Lane, layout: Layout, roads: Roads) -> Iterator[DirectedLane]:
    both = {(one.start, one.end): one.both_ways for one in layout.lanes}
    for ends in driven_through(lane, both):
        road = roads.lane(*ends)
        if road is not None:
            yield road


def _cannot_stand(lane: Lane, through: list[DirectedLane], layout: Layout, file: PlantFile) -> str:
    """Why a door cannot stand on a lane; empty where it can."""
    if lane.shape:
        return Reason("door_bent")
    if not through:
        return Reason("door_short_road", start=lane.start, end=lane.end)
    size = Size.of(file.vehicle_types)
    need_m = 2.0 * (size.turning_radius_m + MARGIN_M) + LEAF_M
    for road in through:
        if road.start in layout.inner:
            return Reason("door_at_crossing", node=road.start)
        if road.length_m < need_m:
            return Reason(
                "door_no_room", start=road.start, end=road.end, away_m=road.length_m, needed_m=need_m
            )
    return ""


def _in_others_way(
    index: int, door: Door, through: list[DirectedLane], layout: Layout, roads: Roads, file: PlantFile
) -> Iterator[Fault]:
    """Lanes that the shut door reaches into, and that it does not know of."""
    nodes = {node.id: node for node in layout.nodes}
    types = {kind.id: kind for kind in file.vehicle_types}
    size = Size.of(file.vehicle_types)
    own: set[Ends] = {(road.start, road.end) for road in through}
    leaves = [leaf_of(road, nodes, types) for road in through]
    for lane in roads.lanes:
        if (lane.start, lane.end) in own:
            continue
        covers = driven(nodes[lane.start], nodes[lane.end], size.length_m, size.width_m)
        if any(gap_m(covers, leaf) < 0.0 for leaf in leaves):
            reason = Reason("door_in_way", door=door.id, start=lane.start, end=lane.end)
            yield f"doors[{index}].lanes", reason
            return
