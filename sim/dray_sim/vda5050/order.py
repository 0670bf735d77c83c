"""The order that a simulated vehicle has, as it has read it from the wire."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import pairwise
from math import hypot
from typing import Any

from dray.body import Charge, Drop, Pick
from dray.messages import Pose
from dray_sim.bodies.held_out import NOBODY_THERE


@dataclass
class NodeAction:
    """An action, and how far it has come."""

    id: str
    type: str
    parameters: dict[str, Any]
    status: str = "WAITING"
    result: str = ""


@dataclass
class Point:
    """A node of the order."""

    id: str
    sequence: int
    released: bool
    x: float | None
    y: float | None
    actions: list[NodeAction]

    def gap_m(self, pose: Pose) -> float:
        """Distance of a vehicle from it; 0 where the order does not give its position."""
        return 0.0 if self.x is None or self.y is None else hypot(self.x - pose.x_m, self.y - pose.y_m)


@dataclass
class Order:
    """An order with its updates.

    Attributes:
        points: base and horizon.
        edges: (edgeId, sequenceId, released).
        reached: the index of the last point that was reached; -1 before the first one.
    """

    id: str
    update: int
    points: list[Point]
    edges: list[tuple[str, int, bool]]
    reached: int = -1
    cancelled: bool = False
    loses: bool = False
    actions: list[NodeAction] = field(default_factory=list)

    @property
    def base_end(self) -> int:
        """The index of the last released point."""
        return max((i for i, point in enumerate(self.points) if point.released), default=-1)

    @property
    def ahead(self) -> range:
        """Indexes from the point that was reached to the next one with an action, or to the end of the base."""
        after = range(self.reached + 1, self.base_end + 1)
        stop = next((i for i in after if self.points[i].actions), self.base_end)
        return range(self.reached, stop + 1)

    @property
    def is_over(self) -> bool:
        """Whether all work is done, and nothing is to come."""
        over = all(action.status in ("FINISHED", "FAILED") for action in self.actions)
        return self.cancelled or (over and self.reached >= len(self.points) - 1)

    def give_up(self) -> None:
        """End it now: unfinished actions have failed."""
        self.cancelled = True
        for action in self.actions:
            action.status = action.status if action.status == "FINISHED" else "FAILED"


def read_message(data: bytes) -> dict[str, Any]:
    """The message; empty for an invalid one, which is ignored."""
    try:
        said = json.loads(data)
    except ValueError:
        return {}
    return said if isinstance(said, dict) else {}


def read_order(said: dict[str, Any]) -> Order:
    """An order, or an update of one, from its JSON."""
    points = [_point(node) for node in said["nodes"]]
    edges = [(edge["edgeId"], edge["sequenceId"], edge["released"]) for edge in said["edges"]]
    order = Order(said["orderId"], said["orderUpdateId"], points, edges)
    order.actions = [action for point in points for action in point.actions]
    return order


def read_actions(said: dict[str, Any]) -> list[NodeAction]:
    """The actions of `instantActions`, in any version."""
    return [_action(action) for action in said.get("actions") or said.get("instantActions") or ()]


def instruction_of(action: NodeAction, number: int, charger: str) -> Pick | Drop | Charge | None:
    """An action at a node as an instruction for its body; None for an impossible one."""
    said = action.parameters
    station = str(said.get("stationName", ""))
    match action.type:
        case "pick" | "waitForTrigger":
            item, quantity = str(said.get("loadType", "")), int(said.get("quantity", 1))
            return Pick(order=number, station=station, item=item, quantity=quantity)
        case "drop":
            return Drop(order=number, station=station, goal=str(said.get("goal", "")))
        case "startCharging":
            return Charge(order=number, charger=station or charger)
    return None


def waits_for_person(action: NodeAction | None, reason: str) -> bool:
    """Whether an action that could not be done is one that goes on when a person loads the vehicle."""
    return action is not None and action.type == "waitForTrigger" and reason == NOBODY_THERE


def over_corners(
    order: Order, ahead: list[int], start: str, corners: Mapping[tuple[str, str], tuple[str, ...]]
) -> tuple[tuple[str, ...], list[int]]:
    """Points of an order as its body drives them: with the corners of lanes that are not straight.

    Args:
        order: it knows nothing of corners.
        ahead: indexes of its points.
        start: where the body begins: at the first of them, or at a corner on the way to it.
        corners: of lanes, by their ends.

    Returns:
        Nodes, and for each its index in the order; -1 for a corner.
    """
    first = order.points[ahead[0]].id
    nodes, indexes = [first], [ahead[0]]
    if start != first:
        on_way = next(
            (c[c.index(start) :] for (_, end), c in corners.items() if end == first and start in c), ()
        )
        nodes, indexes = [*on_way, first], [-1] * len(on_way) + [ahead[0]]
    for before, after in pairwise(ahead):
        between = corners.get((order.points[before].id, order.points[after].id), ())
        nodes += (*between, order.points[after].id)
        indexes += (*(-1 for _ in between), after)
    return tuple(nodes), indexes


def _point(node: dict[str, Any]) -> Point:
    position = node.get("nodePosition") or {}
    actions = [_action(action) for action in node["actions"]]
    return Point(
        node["nodeId"], node["sequenceId"], node["released"], position.get("x"), position.get("y"), actions
    )


def _action(action: dict[str, Any]) -> NodeAction:
    parameters = {pair["key"]: pair["value"] for pair in action.get("actionParameters") or ()}
    kind = action.get("actionType") or action["actionName"]
    return NodeAction(action["actionId"], kind, parameters)
