"""A plant as LIF 1.0.0, for other systems. `dray.plant.exchange.read` makes the same nodes, lanes, chargers and parking places of it.

What is written is the floor as it is driven: of a road of two lanes the stop points and its one-way lanes, since another system knows
no right of way that could keep vehicles apart on the middle line. A lane with a shape is one edge with a trajectory of degree 1.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import msgspec

from dray.plant.exchange.lif import CREATOR
from dray.plant.layout import Layout, lay_out
from dray.plant.model import Box, Lane, Node, PlantFile, Point
from dray.plant.plant import Plant

VERSION = "1.0.0"

ACTIONS = {
    "chargers": ("startCharging", "stopCharging"),
    "parkings": ("park",),
    "places": ("pick", "drop"),
}
"""What vehicles do at a station: names of VDA 5050, and one of ours for parking places."""

Json = dict[str, Any]


def export_lif(plant: Plant, exported_at: str) -> str:
    """The text of a LIF file.

    Args:
        plant: what is written.
        exported_at: when, as LIF wants it: ISO 8601 in UTC, `2026-11-23T08:00:00Z`.
    """
    file, layout = plant.file, lay_out(plant.file)
    types = [kind.id for kind in file.vehicle_types]
    actions = dict(_actions(file))
    document = {
        "metaInformation": {
            "projectIdentification": file.name,
            "creator": CREATOR,
            "exportTimestamp": exported_at,
            "lifVersion": VERSION,
        },
        "layouts": [
            {
                "layoutId": file.plant,
                "layoutName": file.name,
                "layoutVersion": "1",
                "layoutDescription": "Metres; x to the right, y up.",
                "nodes": [_node(node, types, actions.get(node.id, ()), file.plant) for node in layout.nodes],
                "edges": list(_edges(layout, types)),
                "stations": list(_stations(file)),
            }
        ],
    }
    return msgspec.json.format(msgspec.json.encode(document)).decode() + "\n"


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


def _edges(layout: Layout, types: list[str]) -> Iterator[Json]:
    """One edge for each direction; the way back of a lane follows it at once."""
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
    """What is done at a node. Of places that share one, the last counts: chargers before all others."""
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
