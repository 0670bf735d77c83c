"""Puts a layout onto a plant: positions come from the layout, all other data from the plant."""

from __future__ import annotations

from typing import Any

import msgspec

from dray.plant.floor.sizes import fitted
from dray.plant.layout import lay_out
from dray.plant.plant import Plant

FLOOR = ("nodes", "lanes")
"""Sections of the layout. The plant's data of a lane stay where LIF has none."""

PLACES = ("warehouses", "storages", "chargers", "parkings", "machines")
"""Sections whose entries stand at nodes."""

Data = dict[str, Any]


def put_onto(imported: Data, plant: Plant) -> Data:
    """Take an imported plant file, and fill its open values from a plant.

    Where the layout is the floor of the plant as it is driven, the result is the plant itself: its two-lane roads are
    not taken apart. A place whose node the layout does not have is open again (its node is null).

    Args:
        imported: `dray.plant.exchange.assemble.Imported.data`.
        plant: one without faults.
    """
    known: Data = msgspec.to_builtins(plant.file)
    result: Data = {**imported, **{key: value for key, value in known.items() if key not in FLOOR}}
    result["maps"] = imported.get("maps") or known["maps"]
    _name_places(result, imported)
    if _driven(imported) == _driven(_floor(plant)):
        result |= {key: known[key] for key in FLOOR}
        _name_floor(result, imported)
        return result
    _name_floor(result, known)
    nodes = {node["id"] for node in imported["nodes"]}
    for section in PLACES:
        for place in result[section]:
            if place["node"] not in nodes:
                place["node"] = None
    for vehicle in result["fleet"]:
        if vehicle["node"] not in nodes:
            vehicle["node"] = None
    placed = {place["id"] for section in PLACES for place in result[section]}
    # A station that the plant already has needs no assignment, nor do its other nodes.
    result["unassigned"] = [
        one for one in imported["unassigned"] if not placed & {one["id"], one.get("part_of")}
    ]
    for side in ("width_m", "height_m"):
        result[side] = max(known[side], imported[side])
    result["two_lanes"] = False
    return result


def _name_floor(result: Data, other: Data) -> None:
    """Copy the vehicles' names of nodes and lanes from another file, where it has any."""
    nodes: dict[str, Data] = {node["id"]: node for node in other["nodes"]}
    result["nodes"] = tuple(
        {**node, **_said(nodes.get(node["id"], {}), "originals", "map", "max_vehicle")}
        for node in result["nodes"]
    )
    edges: dict[tuple[str, str], Any] = {}
    for lane in other["lanes"]:
        edges[lane["start"], lane["end"]] = lane.get("original")
        if lane.get("both_ways"):
            edges[lane["end"], lane["start"]] = lane.get("original_back")
    named = []
    for lane in result["lanes"]:
        there, back = edges.get((lane["start"], lane["end"])), edges.get((lane["end"], lane["start"]))
        names = {"original": there, "original_back": back if lane.get("both_ways") else None}
        named.append({**lane, **_said(names, *names)})
    result["lanes"] = tuple(named)


def _name_places(result: Data, imported: Data) -> None:
    """Copy the vehicles' names of places from a layout."""
    sections = [imported.get(section) or () for section in ("unassigned", "chargers", "parkings")]
    names: dict[str, Data] = {place["id"]: place for places in sections for place in places}
    for section in PLACES:
        for place in result[section]:
            place.update(_said(names.get(place["id"], {}), "original"))


def _said(of: Data, *keys: str) -> Data:
    return {key: of[key] for key in keys if of.get(key)}


def _floor(plant: Plant) -> Data:
    layout = lay_out(fitted(plant.file))
    floor: Data = msgspec.to_builtins({"nodes": layout.nodes, "lanes": layout.lanes})
    return floor


def _driven(data: Data) -> tuple[object, ...]:
    """Nodes and directed lanes, independent of their order."""
    lanes = set()
    for lane in data["lanes"]:
        shape = tuple((corner["x_m"], corner["y_m"]) for corner in lane.get("shape", ()))
        limit_mps = float(lane.get("speed_limit_mps", 1.5))
        types = lane.get("types", ())
        limits = (
            frozenset(
                (each["type"], min(each.get("speed_limit_mps") or limit_mps, limit_mps)) for each in types
            )
            if types
            else limit_mps
        )
        lanes.add((lane["start"], lane["end"], limits, shape))
        if lane.get("both_ways"):
            lanes.add((lane["end"], lane["start"], limits, shape[::-1]))
    nodes = {(node["id"], float(node["x_m"]), float(node["y_m"])) for node in data["nodes"]}
    return nodes, lanes
