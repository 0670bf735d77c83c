"""Faults of the floor in a plant file: positions and lanes."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from itertools import pairwise
from math import ceil, hypot

from dray.plant.file.reasons import Reason, listed
from dray.plant.floor.geometry import area_m2, crossed_edges
from dray.plant.floor.shapes import corner_names, corners_of, joined_floor
from dray.plant.floor.sizes import too_large_for
from dray.plant.layout import Layout, dock_nodes, stop_names
from dray.plant.model import Area, Box, Lane, Node, PlantFile
from dray.plant.roads import Roads

MAX_SIDE_M = 10_000.0
"""Ten kilometres: no factory floor is longer, but one written in millimetres is."""

MAX_CELLS = 10_000
"""A vehicle hears one cell, but an announcement to the whole plant goes to all of them."""

MIN_LANE_M = 0.05
"""Shorter lanes are two nodes on one spot."""

MIN_PIECE_M = 0.01
"""Shortest distance between two corners of a lane; a shorter piece has no direction."""

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
    layout = joined_floor(file)
    yield from _starts(file, layout)
    if layout is not None:
        # Else the docks of a misspelt lane are unknown.
        yield from _unreachable(file, layout)
    for index, area in enumerate(file.areas):
        yield from _area(area, f"areas[{index}].polygon")


def _size(file: PlantFile) -> Iterator[tuple[str, str]]:
    for field, side_m in (("width_m", file.width_m), ("height_m", file.height_m)):
        if side_m > MAX_SIDE_M:
            yield field, Reason("floor_side", side_m=side_m, most_m=MAX_SIDE_M)
            return
    cells = ceil(file.width_m / file.cell_m) * ceil(file.height_m / file.cell_m)
    if cells > MAX_CELLS:
        yield "cell_m", Reason("floor_cells", count=cells, most=MAX_CELLS)


def _outside(file: PlantFile) -> Iterator[tuple[str, str]]:
    """Nodes, boxes and corners that are not on the floor."""
    for index, node in enumerate(file.nodes):
        if not _on_floor(file, node.x_m, node.y_m):
            yield f"nodes[{index}]", _outside_of(file, node.x_m, node.y_m)
    for section in ("warehouses", "storages", "chargers", "machines"):
        for index, spec in enumerate(getattr(file, section)):
            if not all(_on_floor(file, x_m, y_m) for x_m, y_m in _corners(spec.box)):
                reason = Reason("box_outside", width_m=file.width_m, height_m=file.height_m)
                yield f"{section}[{index}].box", reason
    for index, area in enumerate(file.areas):
        for at, point in enumerate(area.polygon):
            if not _on_floor(file, point.x_m, point.y_m):
                yield f"areas[{index}].polygon[{at}]", _outside_of(file, point.x_m, point.y_m)


def _outside_of(file: PlantFile, x_m: float, y_m: float) -> Reason:
    return Reason("outside", x_m=x_m, y_m=y_m, width_m=file.width_m, height_m=file.height_m)


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
            yield f"{where}.end", Reason("lane_to_itself", node=lane.start)
            continue
        if lane.start in nodes and lane.end in nodes:
            length_m = _length_m(nodes[lane.start], nodes[lane.end])
            if length_m < MIN_LANE_M:
                yield where, Reason("nodes_on_one_spot", start=lane.start, end=lane.end, away_m=length_m)
        for ends in _directions(lane):
            if ends in owners:
                first = f"lanes[{owners[ends]}]"
                yield where, Reason("lane_twice", first=first, start=ends[0], end=ends[1])
            owners.setdefault(ends, index)


def _length_m(start: Node, end: Node) -> float:
    return hypot(end.x_m - start.x_m, end.y_m - start.y_m)


def _directions(lane: Lane) -> tuple[tuple[str, str], ...]:
    there = (lane.start, lane.end)
    return (there, there[::-1]) if lane.both_ways else (there,)


def _two_lanes(file: PlantFile) -> Iterator[tuple[str, str]]:
    """Lanes with impossible properties, and nodes with the names of stop points."""
    docks = dock_nodes(file)
    for index, lane in enumerate(file.lanes):
        if lane.two_lanes:
            where = f"lanes[{index}].two_lanes"
            if lane.shape:
                yield where, Reason("two_lanes_shape")
            elif not lane.both_ways:
                yield where, Reason("two_lanes_one_way")
            elif dock := next((end for end in (lane.start, lane.end) if end in docks), None):
                yield where, Reason("two_lanes_dock", node=dock)
    if file.two_lanes or any(lane.two_lanes for lane in file.lanes):
        taken = stop_names(file)
        for index, node in enumerate(file.nodes):
            if node.id in taken:
                yield f"nodes[{index}].id", Reason("name_of_stop", node=node.id)


def _shapes(file: PlantFile) -> Iterator[tuple[str, str]]:
    """Corners that lie on one another or beside the floor, and nodes that are called as a corner is."""
    nodes = {node.id: node for node in file.nodes}
    for index, lane in enumerate(file.lanes):
        for at, corner in enumerate(lane.shape):
            if not _on_floor(file, corner.x_m, corner.y_m):
                yield f"lanes[{index}].shape[{at}]", _outside_of(file, corner.x_m, corner.y_m)
        if lane.shape and lane.start in nodes and lane.end in nodes:
            points = corners_of(lane, nodes[lane.start], nodes[lane.end])
            for at, (before, after) in enumerate(pairwise(points)):
                if hypot(after.x_m - before.x_m, after.y_m - before.y_m) < MIN_PIECE_M:
                    where = f"lanes[{index}].shape[{min(at, len(lane.shape) - 1)}]"
                    yield where, Reason("corners_near", least_m=MIN_PIECE_M)
                    break
    if taken := corner_names(file):
        for index, node in enumerate(file.nodes):
            if node.id in taken:
                yield f"nodes[{index}].id", Reason("name_of_corner", node=node.id)


def _starts(file: PlantFile, layout: Layout | None) -> Iterator[tuple[str, str]]:
    """Faults of first positions: two vehicles on one spot, or one in a crossing."""
    if layout is not None:
        crossing_of = {node: each for each in layout.crossings.values() for node in each.nodes}
        for index, vehicle in enumerate(file.fleet):
            if crossing := crossing_of.get(vehicle.node):
                where = next(iter(crossing.entries), "")
                reason = Reason("starts_in_crossing", node=vehicle.node, example=where)
                yield f"fleet[{index}].node", reason
    owners: dict[str, str] = {}
    for index, vehicle in enumerate(file.fleet):
        if vehicle.node in owners:
            yield (
                f"fleet[{index}].node",
                Reason("stands_there", vehicle=owners[vehicle.node], node=vehicle.node),
            )
        owners.setdefault(vehicle.node, vehicle.id)


def _unreachable(file: PlantFile, layout: Layout) -> Iterator[tuple[str, str]]:
    """Every vehicle must be able to get from every dock to every other, or vehicles strand."""
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
            yield field, Reason("not_reached", name=name, start=example, end=node)
        elif node not in reaching:
            yield field, Reason("not_left", name=name, start=node, end=example)
    everywhere = [dock for dock in docks if dock[2] in reached and dock[2] in reaching]
    yield from _unreachable_by_type(file, roads, everywhere)


def _unreachable_by_type(
    file: PlantFile, roads: Roads, docks: list[tuple[str, str, str]]
) -> Iterator[tuple[str, str]]:
    """Docks that a type of vehicle cannot reach on lanes for it; each vehicle must get everywhere."""
    driving = {vehicle.type for vehicle in file.fleet}
    for index, kind in enumerate(file.vehicle_types):
        own = roads.for_type(kind.id)
        if own is roads or kind.id not in driving or not docks:
            continue
        main = max(own.parts(), key=lambda part: sum(node in part for _, _, node in docks))
        cut_off = [name for _, name, node in docks if node not in main]
        if cut_off:
            narrow = too_large_for(file, kind)
            size = {"length_m": kind.length_m, "width_m": kind.width_m}
            large = Reason("too_large", **size, nodes=listed(narrow)) if narrow else ""
            reason = Reason("type_cut_off", type=kind.id, names=listed(cut_off), large=large)
            yield f"vehicle_types[{index}]", reason


def _area(area: Area, where: str) -> Iterator[tuple[str, str]]:
    if len(area.polygon) > MAX_CORNERS:
        yield where, Reason("too_many_corners", count=len(area.polygon), most=MAX_CORNERS)
        return
    for at, point in enumerate(area.polygon):
        if point == area.polygon[at - 1]:
            yield f"{where}[{at}]", Reason("corner_twice")
            return
    crossed = crossed_edges(area.polygon)
    if crossed is not None:
        yield where, Reason("edges_cross", one=crossed[0], other=crossed[1])
    elif area_m2(area.polygon) < MIN_AREA_M2:
        yield where, Reason("encloses_nothing")
