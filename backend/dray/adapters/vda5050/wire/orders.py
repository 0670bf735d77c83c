"""Orders and instant actions of the master, and their form in a dialect."""

from __future__ import annotations

from collections.abc import Collection
from itertools import pairwise
from math import hypot
from typing import Any, Protocol

import msgspec

from dray.adapters.vda5050.wire.dialects import Dialect

Value = str | float | int | bool | tuple[str, ...]
"""A parameter's value: 3.0 has lists of texts, too."""


class Action(msgspec.Struct, frozen=True):
    """An action at a node, or at once."""

    id: str
    type: str
    blocking: str = "HARD"
    """NONE, SOFT or HARD."""
    parameters: dict[str, Value] = {}


class Spot(msgspec.Struct, frozen=True):
    """A node's position in the vehicle's map, in metres and radians."""

    x: float
    y: float
    map_id: str
    deviation: float
    """The vehicle's allowed distance from it (m)."""
    theta: float | None = None


class OrderNode(msgspec.Struct, frozen=True):
    """A node of an order."""

    id: str
    sequence: int
    """Its sequence number: even, counted together with edges."""
    released: bool
    spot: Spot
    actions: tuple[Action, ...] = ()


class OrderEdge(msgspec.Struct, frozen=True):
    """An edge from the previous to the next node."""

    sequence: int
    released: bool
    start: str
    end: str
    max_speed_mps: float | None = None
    path: tuple[Spot, ...] = ()
    """The corners of an edge that is not straight, both ends included."""


class Order(msgspec.Struct, frozen=True):
    """An order, or an update of one."""

    id: str
    update: int
    nodes: tuple[OrderNode, ...]
    edges: tuple[OrderEdge, ...] = ()

    @property
    def base(self) -> tuple[OrderNode, ...]:
        """Its released nodes, which come first."""
        return tuple(node for node in self.nodes if node.released)


class Naming(Protocol):
    """A vehicle's own names (`Names`)."""

    def node(self, ours: str) -> str:
        """Its name of a node."""

    def edge(self, start: str, end: str) -> str:
        """Its name of the lane between two of our nodes."""


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
        order: the order.
        dialect: its version.
        names: the vehicle's names of nodes and edges.
        trajectory: whether edges that are not straight have their shape; otherwise only their length.
        without: names of optional fields and parameters to leave out.
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
    """One instant action without its header, with the vehicle's name for the list."""
    said = _action(action)
    kind = said.pop("actionType")
    said |= dict.fromkeys(dialect.action_names, kind)
    # For a vehicle that wants an older name, the names of all versions are written.
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
