"""What a plant file may not say about its floor: where things stand, and how lanes join them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from itertools import pairwise
from math import ceil, hypot

from dray.plant.floor.geometry import area_m2, crossed_edges
from dray.plant.floor.shapes import corner_names, corners_of, floor_of
from dray.plant.floor.sizes import too_large_for
from dray.plant.layout import dock_nodes, stop_names
from dray.plant.model import Area, Box, Lane, Node, PlantFile
from dray.plant.roads import Roads

MAX_SIDE_M = 10_000.0
"""Ten kilometres: no factory floor is longer, but one written in millimetres is."""

MAX_CELLS = 10_000
"""A vehicle hears one cell, but an announcement to the whole plant goes to all of them."""

MIN_LANE_M = 0.05
"""Shorter lanes are two nodes on one spot."""

MIN_PIECE_M = 0.01
"""Between two corners of a lane; a shorter piece has no direction."""

MAX_CORNERS = 200
"""Corners of an area: every edge is compared with every other."""

MIN_AREA_M2 = 0.01
"""A smaller area has lost its corners to rounding."""


def floor_faults(file: PlantFile) -> Iterator[tuple[str, str]]:
    """Faults of places, lanes and areas, as (field, reason)."""
    yield from _size(file)
    yield from _outside(file)
    yield from _lanes(file)
    yield from _two_lanes(file)
    yield from _shapes(file)
    yield from _starts(file)
    yield from _unreachable(file)
    for index, area in enumerate(file.areas):
        yield from _area(area, f"areas[{index}].polygon")


def _size(file: PlantFile) -> Iterator[tuple[str, str]]:
    for field, side_m in (("width_m", file.width_m), ("height_m", file.height_m)):
        if side_m > MAX_SIDE_M:
            yield field, f"{side_m:g} m are more than {MAX_SIDE_M:g} m: write metres"
            return
    cells = ceil(file.width_m / file.cell_m) * ceil(file.height_m / file.cell_m)
    if cells > MAX_CELLS:
        yield "cell_m", f"makes {cells} grid cells, more than {MAX_CELLS}: take larger ones"


def _outside(file: PlantFile) -> Iterator[tuple[str, str]]:
    """Nodes, boxes and corners that are not on the floor."""
    floor = f"the floor of {file.width_m:g} m x {file.height_m:g} m"
    for index, node in enumerate(file.nodes):
        if not _on_floor(file, node.x_m, node.y_m):
            yield f"nodes[{index}]", f"({node.x_m:g}, {node.y_m:g}) is outside of {floor}"
    for section in ("warehouses", "storages", "chargers", "machines"):
        for index, spec in enumerate(getattr(file, section)):
            if not all(_on_floor(file, x_m, y_m) for x_m, y_m in _corners(spec.box)):
                yield f"{section}[{index}].box", f"reaches beyond {floor}: x_m and y_m are its middle"
    for index, area in enumerate(file.areas):
        for at, point in enumerate(area.polygon):
            if not _on_floor(file, point.x_m, point.y_m):
                where = f"areas[{index}].polygon[{at}]"
                yield where, f"({point.x_m:g}, {point.y_m:g}) is outside of {floor}"


def _on_floor(file: PlantFile, x_m: float, y_m: float) -> bool:
    return 0.0 <= x_m <= file.width_m and 0.0 <= y_m <= file.height_m


def _corners(box: Box) -> tuple[tuple[float, float], tuple[float, float]]:
    """Two opposite corners: the lower left and the upper right one."""
    half_x_m, half_y_m = box.width_m / 2.0, box.depth_m / 2.0
    return (box.x_m - half_x_m, box.y_m - half_y_m), (box.x_m + half_x_m, box.y_m + half_y_m)


def _lanes(file: PlantFile) -> Iterator[tuple[str, str]]:
    nodes = {node.id: node for node in file.nodes}
    owners: dict[tuple[str, str], int] = {}
    for index, lane in enumerate(file.lanes):
        where = f"lanes[{index}]"
        if lane.start == lane.end:
            yield f"{where}.end", f"the lane joins {lane.start} with itself: name another node"
            continue
        if lane.start in nodes and lane.end in nodes:
            length_m = _length_m(nodes[lane.start], nodes[lane.end])
            if length_m < MIN_LANE_M:
                yield where, f"{lane.start} and {lane.end} are {length_m:g} m apart: make them one node"
        for ends in _directions(lane):
            if ends in owners:
                first = f"lanes[{owners[ends]}]"
                yield where, f"{first} leads from {ends[0]} to {ends[1]} already: remove one of them"
            owners.setdefault(ends, index)


def _length_m(start: Node, end: Node) -> float:
    return hypot(end.x_m - start.x_m, end.y_m - start.y_m)


def _directions(lane: Lane) -> tuple[tuple[str, str], ...]:
    there = (lane.start, lane.end)
    return (there, there[::-1]) if lane.both_ways else (there,)


def _two_lanes(file: PlantFile) -> Iterator[tuple[str, str]]:
    """Lanes that say of themselves what they cannot be, and nodes that are called as a stop point is."""
    docks = dock_nodes(file)
    for index, lane in enumerate(file.lanes):
        if lane.two_lanes:
            where = f"lanes[{index}].two_lanes"
            if lane.shape:
                yield where, "a lane with a shape is single track: leave this out, or draw two one-way lanes"
            elif not lane.both_ways:
                yield where, "the lane runs one way: add `both_ways: true`, or leave this out"
            elif dock := next((end for end in (lane.start, lane.end) if end in docks), None):
                yield where, f"vehicles dock at {dock}: give the dock a spur off this road, or leave this out"
    if file.two_lanes or any(lane.two_lanes for lane in file.lanes):
        taken = stop_names(file)
        for index, node in enumerate(file.nodes):
            if node.id in taken:
                yield f"nodes[{index}].id", f"{node.id} is the name of a stop point: choose another"


def _shapes(file: PlantFile) -> Iterator[tuple[str, str]]:
    """Corners that lie on one another or beside the floor, and nodes that are called as a corner is."""
    nodes = {node.id: node for node in file.nodes}
    for index, lane in enumerate(file.lanes):
        for at, corner in enumerate(lane.shape):
            if not _on_floor(file, corner.x_m, corner.y_m):
                reason = f"({corner.x_m:g}, {corner.y_m:g}) is outside of the floor of {file.width_m:g} m x {file.height_m:g} m"
                yield f"lanes[{index}].shape[{at}]", reason
        if lane.shape and lane.start in nodes and lane.end in nodes:
            points = corners_of(lane, nodes[lane.start], nodes[lane.end])
            for at, (before, after) in enumerate(pairwise(points)):
                if hypot(after.x_m - before.x_m, after.y_m - before.y_m) < MIN_PIECE_M:
                    where = f"lanes[{index}].shape[{min(at, len(lane.shape) - 1)}]"
                    yield where, f"two corners are less than {MIN_PIECE_M:g} m apart: leave one out"
                    break
    if taken := corner_names(file):
        for index, node in enumerate(file.nodes):
            if node.id in taken:
                yield f"nodes[{index}].id", f"{node.id} is the name of a corner of a lane: choose another"


def _starts(file: PlantFile) -> Iterator[tuple[str, str]]:
    """Two vehicles cannot stand on one spot, and none in a crossing."""
    if _is_joined(file):
        layout = floor_of(file)
        crossing_of = {node: each for each in layout.crossings.values() for node in each.nodes}
        for index, vehicle in enumerate(file.fleet):
            if crossing := crossing_of.get(vehicle.node):
                where = next(iter(crossing.entries), "")
                reason = f"{vehicle.node} is a crossing, where nobody stands: name a parking place or a stop point, as {where}"
                yield f"fleet[{index}].node", reason
    owners: dict[str, str] = {}
    for index, vehicle in enumerate(file.fleet):
        if vehicle.node in owners:
            yield f"fleet[{index}].node", f"{owners[vehicle.node]} stands at {vehicle.node} already"
        owners.setdefault(vehicle.node, vehicle.id)


def _is_joined(file: PlantFile) -> bool:
    """Whether every lane joins two nodes that there are; the rest is reported already."""
    nodes = {node.id for node in file.nodes}
    return all(lane.start in nodes and lane.end in nodes and lane.start != lane.end for lane in file.lanes)


def _unreachable(file: PlantFile) -> Iterator[tuple[str, str]]:
    """Everybody must be able to get from every dock to every other, or vehicles strand."""
    if not _is_joined(file):
        # Which docks a misspelt lane was to join is anybody's guess.
        return
    layout = floor_of(file)
    nodes = {node.id for node in layout.nodes}
    roads = Roads(layout.nodes, layout.lanes)
    docks = [
        (f"{section}[{index}].node", spec.id, spec.node)
        for section in ("warehouses", "storages", "chargers", "parkings", "machines", "fleet")
        for index, spec in enumerate(getattr(file, section))
        if spec.node in nodes
    ]
    if not docks:
        return
    here = Counter(node for _, _, node in docks)
    main = max(roads.parts(), key=lambda part: sum(here[node] for node in part))
    example = next(node for _, _, node in docks if node in main)
    reached, reaching = roads.reached_from(example), roads.reaching(example)
    for field, name, node in docks:
        if node not in reached:
            yield field, f"{name} cannot be reached: no lanes lead from {example} to {node}"
        elif node not in reaching:
            yield field, f"{name} cannot be left: no lanes lead from {node} to {example}"
    everywhere = [dock for dock in docks if dock[2] in reached and dock[2] in reaching]
    yield from _unreachable_by_type(file, roads, everywhere)


def _unreachable_by_type(
    file: PlantFile, roads: Roads, docks: list[tuple[str, str, str]]
) -> Iterator[tuple[str, str]]:
    """A lane may be for some types of vehicles only; but each vehicle must get everywhere on lanes that are for it."""
    driving = {vehicle.type for vehicle in file.fleet}
    for index, kind in enumerate(file.vehicle_types):
        own = roads.for_type(kind.id)
        if own is roads or kind.id not in driving or not docks:
            continue
        main = max(own.parts(), key=lambda part: sum(node in part for _, _, node in docks))
        cut_off = [name for _, name, node in docks if node not in main]
        if cut_off:
            more = f" and {len(cut_off) - 3} more" if len(cut_off) > 3 else ""
            reason = (
                f"{kind.id} cannot get to {', '.join(cut_off[:3])}{more} and back on lanes that are for it: "
                f"name it in the `types` of lanes that lead there"
            )
            if narrow := too_large_for(file, kind):
                reason += (
                    f"; with {kind.length_m:g} m x {kind.width_m:g} m it is larger than `max_vehicle` of "
                    f"{', '.join(narrow[:3])}{f' and {len(narrow) - 3} more' if len(narrow) > 3 else ''} allows"
                )
            yield f"vehicle_types[{index}]", reason


def _area(area: Area, where: str) -> Iterator[tuple[str, str]]:
    if len(area.polygon) > MAX_CORNERS:
        yield where, f"{len(area.polygon)} corners are more than {MAX_CORNERS}: draw it more simply"
        return
    for at, point in enumerate(area.polygon):
        if point == area.polygon[at - 1]:
            yield f"{where}[{at}]", "the corner before it is the same: remove one, the polygon closes itself"
            return
    crossed = crossed_edges(area.polygon)
    if crossed is not None:
        yield (
            where,
            f"the edges from corner {crossed[0]} and from corner {crossed[1]} cross: order the corners",
        )
    elif area_m2(area.polygon) < MIN_AREA_M2:
        yield where, "it encloses nothing: give at least three corners that are not in one line"
