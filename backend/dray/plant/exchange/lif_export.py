"""A plant as LIF 1.0.0 or 2.0.0, for other systems. `dray.plant.exchange.read` makes the same nodes, lanes, chargers and parking places of it.

It writes the floor as it is driven: the stop points and one-way lanes of a two-lane road. Another system has no right
of way that could keep vehicles apart on the middle line. A lane with a shape is one edge with a trajectory of degree
1.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import msgspec

from dray.plant.exchange.lif import CREATOR
from dray.plant.floor.sizes import fits, fitted
from dray.plant.layout import Layout, lay_out
from dray.plant.model import Box, Lane, Node, PlantFile, Point
from dray.plant.plant import Plant

VERSIONS = ("1.0.0", "2.0.0")

ACTIONS = {
    "chargers": ("startCharging", "stopCharging"),
    "parkings": ("park",),
    "places": ("pick", "drop"),
}
"""Actions of vehicles at a station: names of VDA 5050, and one of ours for parking places."""

Json = dict[str, Any]


def export_lif(plant: Plant, exported_at: str, version: str = VERSIONS[0]) -> str:
    """The text of a LIF file.

    Args:
        plant: to be written.
        exported_at: when, as LIF wants it: ISO 8601 in UTC, `2026-11-23T08:00:00Z`.
        version: of LIF, one of `VERSIONS`.
    """
    file, layout = plant.file, lay_out(fitted(plant.file))
    types = [kind.id for kind in file.vehicle_types]
    actions = dict(_actions(file))
    document = {
        "metaInformation": {
            "projectIdentification": file.name,
            "creator": CREATOR,
            "exportTimestamp": exported_at,
            "lifVersion": VERSIONS[0],
        },
        "layouts": [
            {
                "layoutId": file.plant,
                "layoutName": file.name,
                "layoutVersion": "1",
                "layoutDescription": "Metres; x to the right, y up.",
                "nodes": [
                    _node(node, _at(node, file) or types, actions.get(node.id, ()), file.plant)
                    for node in layout.nodes
                ],
                "edges": list(_edges(layout, types)),
                "stations": list(_stations(file)),
            }
        ],
    }
    if version == VERSIONS[1]:
        document = _as_2_0_0(document, file)
    return msgspec.json.format(msgspec.json.encode(document)).decode() + "\n"


def _as_2_0_0(document: Json, file: PlantFile) -> Json:
    """A document of 1.0.0 by the names of 2.0.0, which has origins and types with their manufacturer."""
    (layout,) = document["layouts"]
    told = document["metaInformation"]
    return {
        "metaInformation": {
            "lifId": file.plant,
            **{key: told[key] for key in ("creator", "exportTimestamp")},
            "lifVersion": VERSIONS[1],
        },
        "origins": [
            {
                "originId": file.plant,
                "originDescriptor": file.name,
                "layouts": [
                    {
                        **_renamed(layout, {"layoutDescription": "layoutDescriptor"}),
                        "nodes": [_node_2_0_0(node) for node in layout["nodes"]],
                        "edges": [_edge_2_0_0(edge) for edge in layout["edges"]],
                        "stations": [
                            _renamed(station, {"stationDescription": "stationDescriptor"})
                            for station in layout["stations"]
                        ],
                    }
                ],
            }
        ],
    }


def _node_2_0_0(node: Json) -> Json:
    """All types do the same at a node of ours, so they share their properties."""
    properties = node["vehicleTypeNodeProperties"]
    shared: Json = {"mobileRobotTypes": [_robot(each["vehicleTypeId"]) for each in properties]}
    if actions := properties[0].get("actions"):
        shared["feasibleActions"] = [
            {key: action[key] for key in ("actionType", "blockingType")} for action in actions
        ]
    rest = {key: value for key, value in node.items() if key != "vehicleTypeNodeProperties"}
    return {**rest, "mobileRobotTypeNodeProperties": [shared]}


def _edge_2_0_0(edge: Json) -> Json:
    """Types of one limit share their properties."""
    by_limit: dict[float, Json] = {}
    for each in edge["vehicleTypeEdgeProperties"]:
        shared = by_limit.setdefault(
            each["maxSpeed"],
            {
                "mobileRobotTypes": [],
                "reachOrientationBeforeEntering": not each["rotationAllowed"],
                "maximumSpeed": each["maxSpeed"],
                **({"trajectory": each["trajectory"]} if "trajectory" in each else {}),
            },
        )
        shared["mobileRobotTypes"].append(_robot(each["vehicleTypeId"]))
    rest = {key: value for key, value in edge.items() if key != "vehicleTypeEdgeProperties"}
    return {**rest, "mobileRobotTypeEdgeProperties": list(by_limit.values())}


def _robot(kind: str) -> Json:
    """A type of vehicles; a plant does not know its manufacturer."""
    return {"manufacturer": "", "seriesName": kind}


def _renamed(of: Json, names: dict[str, str]) -> Json:
    return {names.get(key, key): value for key, value in of.items()}


def _node(node: Node, types: list[str], actions: tuple[str, ...], map_id: str) -> Json:
    properties: Json = {}
    if actions:
        properties["actions"] = [
            {"actionType": action, "requirementType": "CONDITIONAL", "blockingType": "HARD"}
            for action in actions
        ]
    return {
        "nodeId": node.id,
        "mapId": map_id,
        "nodePosition": {"x": node.x_m, "y": node.y_m},
        "vehicleTypeNodeProperties": [{"vehicleTypeId": kind, **properties} for kind in types],
    }


def _at(node: Node, file: PlantFile) -> list[str]:
    """The types that are no larger than a node allows: LIF has no sizes."""
    return [kind.id for kind in file.vehicle_types if fits(kind, node)]


def _edges(layout: Layout, types: list[str]) -> Iterator[Json]:
    """One edge for each direction; a lane's way back follows directly."""
    nodes = {node.id: node for node in layout.nodes}
    for lane in layout.lanes:
        yield _edge(lane, lane.start, lane.end, list(lane.shape), types, nodes)
        if lane.both_ways:
            yield _edge(lane, lane.end, lane.start, list(reversed(lane.shape)), types, nodes)


def _edge(
    lane: Lane, start: str, end: str, shape: list[Point], types: list[str], nodes: dict[str, Node]
) -> Json:
    properties: Json = {
        "rotationAllowed": False,
    }
    limit_mps = lane.speed_limit_mps
    own = {each.type: min(each.speed_limit_mps or limit_mps, limit_mps) for each in lane.types}
    if shape:
        ends = [Point(nodes[node].x_m, nodes[node].y_m) for node in (start, end)]
        points = [ends[0], *shape, ends[1]]
        last = len(points) - 1
        properties["trajectory"] = {
            "degree": 1,
            "knotVector": [0.0, *(index / last for index in range(last + 1)), 1.0],
            "controlPoints": [{"x": point.x_m, "y": point.y_m} for point in points],
        }
    return {
        "edgeId": f"{start}--{end}",
        "startNodeId": start,
        "endNodeId": end,
        "vehicleTypeEdgeProperties": [
            {"vehicleTypeId": kind, "maxSpeed": own.get(kind, limit_mps), **properties}
            for kind in own or types
        ],
    }


def _actions(file: PlantFile) -> Iterator[tuple[str, tuple[str, ...]]]:
    """The actions at each node. For places that share one, the last counts: chargers before all others."""
    for places in (file.parkings, file.machines, file.storages, file.warehouses, file.chargers):
        for place in places:
            kind = (
                "parkings" if places is file.parkings else "chargers" if places is file.chargers else "places"
            )
            yield place.node, ACTIONS[kind]


def _stations(file: PlantFile) -> Iterator[Json]:
    for section, places in (
        ("Machine", file.machines),
        ("Storage", file.storages),
        ("Warehouse", file.warehouses),
        ("Charger", file.chargers),
        ("Parking place", file.parkings),
    ):
        for place in places:
            box: Box | None = getattr(place, "box", None)
            at = {} if box is None else {"stationPosition": {"x": box.x_m, "y": box.y_m}}
            yield {
                "stationId": place.id,
                "interactionNodeIds": [place.node],
                "stationName": getattr(place, "name", place.id),
                "stationDescription": section,
                **at,
            }
