"""What a plant file may not say about its doors: each stands on lanes that it names, with room to wait before it."""

from __future__ import annotations

from collections.abc import Iterator

from dray.plant.floor.doors import LEAF_M, Ends, driven_through, lanes_between, leaf_of
from dray.plant.floor.rectangles import driven, gap_m
from dray.plant.floor.shapes import floor_of
from dray.plant.layout import MARGIN_M, Layout, Size
from dray.plant.model import Door, Lane, PlantFile
from dray.plant.roads import DirectedLane, Roads

Fault = tuple[str, str]
"""Field and reason."""


def door_faults(file: PlantFile) -> Iterator[Fault]:
    """Faults of doors, as (field, reason). Where lanes join what is not there, that is reported already."""
    if not file.doors:
        return
    lanes = lanes_between(file)
    owners: dict[Lane, str] = {}
    joined = _is_joined(file)
    layout = floor_of(file) if joined else None
    roads = None if layout is None else Roads(layout.nodes, layout.lanes)
    for index, door in enumerate(file.doors):
        through: list[DirectedLane] = []
        faulty = False
        for at, named in enumerate(door.lanes):
            where = f"doors[{index}].lanes[{at}]"
            lane = lanes.get((named.start, named.end))
            if lane is None:
                faulty = True
                yield where, f"no lane joins {named.start} and {named.end}: draw it, or name another"
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


def _is_joined(file: PlantFile) -> bool:
    nodes = {node.id for node in file.nodes}
    ends = [(lane.start, lane.end) for lane in file.lanes]
    return all(start in nodes and end in nodes and start != end for start, end in ends)


def _twice(lane: Lane, owner: str, door: Door) -> str:
    way = f"the lane from {lane.start} to {lane.end}"
    if owner == door.id:
        both = " both directions are shut together:" if lane.both_ways else ""
        return f"{way} is named already:{both} keep one of the two"
    return f"{owner} stands on {way} already: keep one of the two"


def _driven(lane: Lane, layout: Layout, roads: Roads) -> Iterator[DirectedLane]:
    both = {(one.start, one.end): one.both_ways for one in layout.lanes}
    for ends in driven_through(lane, both):
        road = roads.lane(*ends)
        if road is not None:
            yield road


def _cannot_stand(lane: Lane, through: list[DirectedLane], layout: Layout, file: PlantFile) -> str:
    """Why a door cannot stand on a lane; empty where it can."""
    if lane.shape:
        return "a door stands on a straight lane: divide this one at a node"
    if not through:
        return (
            f"the road from {lane.start} to {lane.end} is too short for a vehicle to stop before and after a door: "
            f"make it longer, or say `two_lanes: false` of it"
        )
    size = Size.of(file.vehicle_types)
    need_m = 2.0 * (size.turning_radius_m + MARGIN_M) + LEAF_M
    for road in through:
        if road.start in layout.inner:
            return f"nobody can wait at {road.start}, which is a crossing: put a node between it and the door"
        if road.length_m < need_m:
            return f"{road.start} and {road.end} are {road.length_m:.2f} m apart: whoever turns there needs {need_m:.2f} m, with the door between them"
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
            reason = f"{door.id} is in the way from {lane.start} to {lane.end}, too: name that lane here, or move it away"
            yield f"doors[{index}].lanes", reason
            return
