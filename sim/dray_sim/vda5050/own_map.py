"""The map of a vehicle that knows only its own ids and its own frame: all its messages are translated on board.

It stands between the wire and a `Vda5050Vehicle`, whose body drives by the plant's ids. An order with an id that the
map does not have is not taken. It is written beside the driver's `Names`, and not with it: each would find a mistake
of the other.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from math import atan2, cos, sin
from typing import Any


@dataclass(frozen=True)
class Axes:
    """One map: its u and v are those of the plant less its origin, turned, mirrored and divided by the unit."""

    x_m: float = 0.0
    y_m: float = 0.0
    turn: float = 0.0
    """Direction of its first axis, counterclockwise (rad)."""
    flip: int = 1
    """-1 where its second axis lies to the right of the first one."""
    unit_m: float = 1.0

    def inward(self, u: float, v: float) -> tuple[float, float]:
        """A point of the map, in the plant."""
        u, v = u * self.unit_m, v * self.unit_m * self.flip
        return self.x_m + u * cos(self.turn) - v * sin(self.turn), self.y_m + u * sin(self.turn) + v * cos(
            self.turn
        )

    def outward(self, x_m: float, y_m: float) -> tuple[float, float]:
        """A point of the plant, in the map."""
        east, north = x_m - self.x_m, y_m - self.y_m
        u = east * cos(self.turn) + north * sin(self.turn)
        v = north * cos(self.turn) - east * sin(self.turn)
        return u / self.unit_m, v * self.flip / self.unit_m

    def angle(self, heading: float) -> float:
        """A heading of the plant, in the map (rad)."""
        turned = (heading - self.turn) * self.flip
        return atan2(sin(turned), cos(turned))


@dataclass
class OwnMap:
    """The map of one vehicle.

    Attributes:
        nodes: (map, its own id) -> the plant's.
        stations: its own id -> the plant's.
        axes: of each map, by its id.
        edges: ids that an edge may have; None for any.
        unknown: ids in messages to it that it does not know.
        said: ids of nodes and edges in the orders that it has taken.
    """

    nodes: Mapping[tuple[str, str], str]
    stations: Mapping[str, str]
    axes: Mapping[str, Axes]
    edges: frozenset[str] | None = None
    unknown: list[str] = field(default_factory=list)
    said: set[str] = field(default_factory=set)
    _map: str = ""
    """The map of its last node."""

    def heard(self, topic: str, said: dict[str, Any]) -> dict[str, Any] | None:
        """A message to it, with the plant's ids; None for one that it rejects."""
        if topic != "order":
            return said
        strange = [*self._strange_nodes(said["nodes"]), *self._strange_edges(said["edges"])]
        self.unknown += strange
        if strange:
            return None
        self.said |= {each.get("nodeId") or each["edgeId"] for each in (*said["nodes"], *said["edges"])}
        return {**said, "nodes": [self._node(node) for node in said["nodes"]]}

    def told(self, said: dict[str, Any]) -> dict[str, Any]:
        """A message of it, with its own ids instead of the plant's."""
        result = dict(said)
        if last := said.get("lastNodeId"):
            result["lastNodeId"], self._map = self._theirs(last), self._map_at(last)
        map_id = self._map or next(iter(self.axes))
        for key in ("agvPosition", "mobileRobotPosition"):
            if key in said:
                at, axes = said[key], self.axes[map_id]
                u, v = axes.outward(at["x"], at["y"])
                result[key] = {**at, "x": u, "y": v, "theta": axes.angle(at["theta"]), "mapId": map_id}
        if "nodeStates" in said:
            result["nodeStates"] = [
                {**node, "nodeId": self._theirs(node["nodeId"])} for node in said["nodeStates"]
            ]
        return result

    def _map_at(self, node: str) -> str:
        """The map on which a node of the plant lies; that of the node before for one that is none."""
        return next((map_id for (map_id, _), ours in self.nodes.items() if ours == node), self._map)

    def _theirs(self, node: str) -> str:
        return next((theirs for (_, theirs), ours in self.nodes.items() if ours == node), node)

    def _strange_nodes(self, nodes: Iterable[dict[str, Any]]) -> list[str]:
        return [
            f"{node['nodeId']} on {node['nodePosition']['mapId']}"
            for node in nodes
            if (node["nodePosition"]["mapId"], node["nodeId"]) not in self.nodes
        ]

    def _strange_edges(self, edges: Iterable[dict[str, Any]]) -> list[str]:
        return [
            edge["edgeId"] for edge in edges if self.edges is not None and edge["edgeId"] not in self.edges
        ]

    def _node(self, node: dict[str, Any]) -> dict[str, Any]:
        at = node["nodePosition"]
        x_m, y_m = self.axes[at["mapId"]].inward(at["x"], at["y"])
        return {
            **node,
            "nodeId": self.nodes[at["mapId"], node["nodeId"]],
            "nodePosition": {**at, "x": x_m, "y": y_m},
            "actions": [self._action(action) for action in node["actions"]],
        }

    def _action(self, action: dict[str, Any]) -> dict[str, Any]:
        pairs = [
            {**pair, "value": self.stations.get(pair["value"], f"no {pair['value']}")}
            if pair["key"] == "stationName"
            else pair
            for pair in action["actionParameters"]
        ]
        return {**action, "actionParameters": pairs}
