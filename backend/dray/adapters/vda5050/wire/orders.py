"""Orders and instant actions as the master means them, and as a dialect writes them."""

from __future__ import annotations

from collections.abc import Collection
from itertools import pairwise
from math import hypot
from typing import Any, Protocol

import msgspec

from dray.adapters.vda5050.wire.dialects import Dialect

Value = str | float | int | bool | tuple[str, ...]
"""Of a parameter: 3.0 has some that are lists of texts."""


class Action(msgspec.Struct, frozen=True):
    """An action at a node, or at once."""

    id: str
    type: str
    blocking: str = "HARD"
    """NONE, SOFT or HARD."""
    parameters: dict[str, Value] = {}


class Spot(msgspec.Struct, frozen=True):
    """Where a node lies in the vehicle's map, in metres and radians."""

    x: float
    y: float
    map_id: str
    deviation: float
    """How far from it the vehicle may be (m)."""
    theta: float | None = None


class OrderNode(msgspec.Struct, frozen=True):
    """A node of an order."""

    id: str
    sequence: int
    """Even; nodes and edges are counted together."""
    released: bool
    spot: Spot
    actions: tuple[Action, ...] = ()


class OrderEdge(msgspec.Struct, frozen=True):
    """From the node before it to the node after it."""

    sequence: int
    released: bool
    start: str
    end: str
    max_speed_mps: float | None = None
    path: tuple[Spot, ...] = ()
    """Of one that is not straight: its corners, both ends included."""


class Order(msgspec.Struct, frozen=True):
    """An order, or an update of one."""

    id: str
    update: int
    nodes: tuple[OrderNode, ...]
    edges: tuple[OrderEdge, ...] = ()

    @property
    def base(self) -> tuple[OrderNode, ...]:
        """Its released nodes: they come first."""
        return tuple(node for node in self.nodes if node.released)


class Naming(Protocol):
    """What a vehicle calls things (`Names`)."""

    def node(self, ours: str) -> str:
        """What it calls a node."""

    def edge(self, start: str, end: str) -> str:
        """What it calls the lane between two nodes of ours."""


def order_body(
    order: Order,
    dialect: Dialect,
    names: Naming,
    *,
    trajectory: bool = True,
    without: Collection[str] = (),
) -> dict[str, Any]:
    """An order without its header.

    Args:
        order: what is ordered.
        dialect: its version.
        names: what the vehicle calls nodes and edges.
        trajectory: edges that are not straight say their shape; else their length alone.
        without: fields of nodes, positions, edges and actions, and parameters of actions, that are left out.
    """
    nodes = [_node(node, dialect, names) for node in order.nodes]
    edges = [_edge(edge, dialect, names, trajectory=trajectory) for edge in order.edges]
    for part in (*nodes, *edges) if without else ():
        for each in (part, part.get("nodePosition", {}), *part["actions"]):
            for name in without:
                each.pop(name, None)
        for action in part["actions"]:
            kept = [pair for pair in action["actionParameters"] if pair["key"] not in without]
            action["actionParameters"] = kept
    return {"orderId": order.id, "orderUpdateId": order.update, "nodes": nodes, "edges": edges}


def instant_body(action: Action, dialect: Dialect, field: str) -> dict[str, Any]:
    """One instant action without its header, under the name that its vehicle wants for the list."""
    said = _action(action)
    kind = said.pop("actionType")
    said |= dict.fromkeys(dialect.action_names, kind)
    # The name of every version is said, too, where a vehicle wants an older one.
    return {"actions": [said]} if field == "actions" else {"actions": [said], field: [said]}


def _node(node: OrderNode, dialect: Dialect, names: Naming) -> dict[str, Any]:
    spot = node.spot
    position: dict[str, Any] = {"x": spot.x, "y": spot.y, "mapId": spot.map_id}
    if spot.theta is not None:
        position["theta"] = spot.theta
    radius = spot.deviation
    position[dialect.deviation] = {"a": radius, "b": radius, "theta": 0.0} if dialect.is_ellipse else radius
    return {
        "nodeId": names.node(node.id),
        "sequenceId": node.sequence,
        "released": node.released,
        "nodePosition": position,
        "actions": [_action(action) for action in node.actions],
    }


def _edge(edge: OrderEdge, dialect: Dialect, names: Naming, *, trajectory: bool) -> dict[str, Any]:
    said: dict[str, Any] = {
        "edgeId": names.edge(edge.start, edge.end),
        "sequenceId": edge.sequence,
        "released": edge.released,
        "actions": [],
    }
    if dialect.names_ends:
        said |= {"startNodeId": names.node(edge.start), "endNodeId": names.node(edge.end)}
    if edge.max_speed_mps is not None:
        said[dialect.max_speed] = edge.max_speed_mps
    if edge.path:
        said["length"] = sum(hypot(b.x - a.x, b.y - a.y) for a, b in pairwise(edge.path))
        if trajectory:
            last = len(edge.path) - 1
            said["trajectory"] = {
                "degree": 1,
                "knotVector": [0.0, *(index / last for index in range(last + 1)), 1.0],
                "controlPoints": [{"x": spot.x, "y": spot.y} for spot in edge.path],
            }
    return said


def _action(action: Action) -> dict[str, Any]:
    parameters = [{"key": key, "value": value} for key, value in action.parameters.items()]
    return {
        "actionType": action.type,
        "actionId": action.id,
        "blockingType": action.blocking,
        "actionParameters": parameters,
    }
