"""One order of ours at a vehicle: its content, its progress, and its written and stored forms."""

from __future__ import annotations

from collections.abc import Collection
from enum import StrEnum
from itertools import pairwise
from typing import Protocol

import msgspec

from dray.adapters.vda5050.control.order_state import TRANSITIONS, OrderState
from dray.adapters.vda5050.events import OrderMemory
from dray.adapters.vda5050.wire.messages import State, VehicleError
from dray.adapters.vda5050.wire.orders import Action, Order, OrderEdge, OrderNode, Spot
from dray.body import Charge, Drop, Pick
from dray.states import States

ONLY_WAITS = "the action only waits"
NOBODY_LOADS = "nobody has loaded it by hand"


class Kind(StrEnum):
    """The purpose of an order."""

    STEP = "step"
    PICK = "pick"
    DROP = "drop"
    CHARGE = "charge"


Task = Pick | Drop | Charge

Stop = tuple[str, Spot]
"""A node of an order, with its position."""

Place = tuple[int, int] | None
"""A node's place in the agent's way: the number of the way, and the index there; None for no place."""


class VehicleOrder:
    """One order.

    Args:
        kind: its purpose.
        number: the number of the agent's instruction, for reports.
        stops: the nodes of its base; the vehicle is at the first one.
        beyond: the nodes of its horizon.
        speeds_mps: the limit on the edge to each node, base and horizon; the first one is unused.
        action: the action at its last node; None for a step.
        task: the instruction behind the action.
        corners: nodes that the vehicle does not know: edges lead over them. Neither base nor horizon ends at one.

    Attributes:
        origin: the node that the vehicle left last, or stands at.
        ids: all ids under which it was offered; the newest last.
        id: the id that the vehicle shows, else the newest.
        update: the number of the newest update.
        passed: the index of the last passed node of its base.
        places: for each node of the base its place in the agent's way.
        reason: why it has ended without success.
        is_unwanted: whether to cancel it as soon as the vehicle has it.
        is_earlier: whether an earlier life has sent it, to drive: it, or its last update, may still be on its way to the vehicle. It is never
            sent again.
    """

    def __init__(
        self,
        kind: Kind,
        number: int,
        stops: list[Stop],
        beyond: list[Stop],
        speeds_mps: list[float | None],
        action: Action | None = None,
        task: Task | None = None,
        corners: Collection[str] = (),
    ) -> None:
        self._corners = corners
        self.kind, self.number = kind, number
        self.stops, self.beyond, self.speeds_mps = stops, beyond, speeds_mps
        self.action, self.task = action, task
        self.origin = stops[0][0]
        self.ids: list[str] = []
        self.id = ""
        self.update = 0
        self.sent_base = len(stops)
        """Number of base nodes that the vehicle is known to have."""
        self.has_horizon = False
        """Whether the vehicle has a horizon: it does not become idle before that is withdrawn."""
        self.from_node = 0
        """The index of the newest update's first node: the last node of the base before."""
        self.passed = 0
        self.places: list[Place] = [None] * len(stops)
        self.states: States[OrderState] = States("an order", TRANSITIONS, OrderState.OFFERED)
        self.reason = ""
        self.old_errors: frozenset[tuple[str, str, tuple[str, ...]]] = frozenset()
        """The vehicle's errors when the order was offered, or warnings when it was extended: they do not refuse it."""
        self.refused_with = ""
        """The text of its newest refusal with one."""
        self.ended_by: VehicleError | None = None
        """The error that ended it; None for none."""
        self.is_unwanted = self.is_earlier = False
        self.takes_updates = True
        self.is_twice = False
        """Whether its node is listed twice."""
        self.begun_s = 0.0
        """The time of the first offer."""
        self.offered_s = self.said_s = 0.0
        self.retry_s = 0.0
        """The earliest time of the next offer."""
        self.by_hand_s: float | None = None
        """Maximum seconds that its action may wait for a person; None where no person is needed."""
        self.waits_since_s: float | None = None
        """Since when its action only waits."""
        self.acts_since_s: float | None = None
        """Since when the vehicle has it, with an action that has not ended."""
        self.quiet_since_s: float | None = None
        """Since when the vehicle has no remaining work, though the order is not done."""
        self.strangers = 0
        """Consecutive states that show another order."""
        self.contradiction = ""
        """How its position contradicts the last node that it reports; empty while it does not."""

    @property
    def nodes(self) -> tuple[str, ...]:
        """The plant's names of its base's nodes: the first one may have another name in the order."""
        return (self.origin, *(stop[0] for stop in self.stops[1:]))

    @property
    def end(self) -> int:
        """The index of the last node of its base."""
        return len(self.stops) - 1

    @property
    def now(self) -> OrderState:
        return self.states.now

    def overdue(self, now_s: float, waiting_s: float) -> str:
        """Why its action has timed out; empty while it has not.

        Args:
            now_s: the present time.
            waiting_s: maximum seconds that an action may show that it waits.
        """
        if self.by_hand_s is not None:
            return NOBODY_LOADS if now_s - self.offered_s >= self.by_hand_s else ""
        waits = self.waits_since_s is not None and now_s - self.waits_since_s >= waiting_s
        return ONLY_WAITS if waits else ""

    def message(self) -> Order:
        """The newest update, as sent; equal each time."""
        first, base_end = self.from_node, self.end
        points = [*self.stops, *self.beyond]
        told = self._told(points)
        nodes = tuple(
            OrderNode(
                id=name,
                sequence=2 * number,
                released=index <= base_end,
                spot=spot,
                actions=(self.action,) if self.action is not None and index == base_end else (),
            )
            for number, (index, (name, spot)) in enumerate((index, points[index]) for index in told)
            if index >= first
        )
        edges = tuple(
            OrderEdge(
                sequence=2 * number - 1,
                released=after <= base_end,
                start=points[before][0],
                end=points[after][0],
                max_speed_mps=min(
                    (speed for speed in self.speeds_mps[before + 1 : after + 1] if speed is not None),
                    default=None,
                ),
                path=tuple(spot for _, spot in points[before : after + 1]) if after > before + 1 else (),
            )
            for number, (before, after) in enumerate(pairwise(told), 1)
            if before >= first
        )
        return Order(self.id, self.update, nodes, edges)

    def memory(self) -> OrderMemory:
        """Its memory for the next life."""
        task = self.task
        return OrderMemory(
            id=self.id,
            update=self.update,
            number=self.number,
            kind=self.kind.value,
            nodes=self.nodes,
            is_shown=self.now not in (OrderState.OFFERED, OrderState.REFUSED),
            action=self.action.id if self.action is not None else "",
            station=task.charger if isinstance(task, Charge) else task.station if task is not None else "",
            item=task.item if isinstance(task, Pick) else "",
            quantity=task.quantity if isinstance(task, Pick) else 0,
            goal=task.goal if isinstance(task, Drop) else "",
        )

    def is_shown_whole(self, state: State) -> bool:
        """Whether the vehicle shows it with its newest update."""
        return self.is_shown(state) and (state.order_update_id or 0) >= self.update

    def is_shown(self, state: State) -> bool:
        """Whether the vehicle shows it under any of its ids, or at least its action."""
        if state.order_id and state.order_id in self.ids:
            return True
        return self.action is not None and state.action(self.action.id) is not None

    def place_in(self, state: State) -> int:
        """The index of the last passed node, by node and sequence number; never decreases."""
        nodes, node = self.nodes, state.last_node_id
        told = self._told(self.stops)
        by_number = (state.last_node_sequence_id or 0) // 2
        if 0 <= by_number < len(told) and nodes[told[by_number]] == node:
            return max(self.passed, told[by_number])
        # For a vehicle with useless sequence numbers.
        if nodes[self.passed] == node:
            return self.passed
        return next((i for i in range(self.passed + 1, len(nodes)) if nodes[i] == node), self.passed)

    def _told(self, points: list[Stop]) -> list[int]:
        """The indexes of the nodes that are in the order: all but corners."""
        return [index for index, (name, _) in enumerate(points) if index == 0 or name not in self._corners]


class Builder(Protocol):
    """Builds orders (`Steps`)."""

    @property
    def corners(self) -> Collection[str]:
        """Nodes that vehicles do not know."""

    def spot(self, node: str) -> Spot:
        """A node's position."""

    def action(self, task: Task, node: str, *, twice: bool | None = None) -> VehicleOrder:
        """An order for a task at a node."""


def restored(memory: OrderMemory, build: Builder) -> VehicleOrder:
    """An earlier life's order: for a task it is equal in every word, since it may have to be sent again.

    Args:
        memory: its stored form, with the plant's names.
        build: the same builder as in the earlier life.
    """
    task = task_of(memory)
    if task is not None:
        order = build.action(task, memory.nodes[-1], twice=len(memory.nodes) > 1)
        if order.action is not None:
            order.action = msgspec.structs.replace(order.action, id=memory.action)
    else:
        stops = [(node, build.spot(node)) for node in memory.nodes]
        order = VehicleOrder(Kind.STEP, memory.number, stops, [], [None] * len(stops), corners=build.corners)
        order.is_earlier = True
    order.id, order.update, order.ids = memory.id, memory.update, [memory.id]
    order.takes_updates = False
    return order


def task_of(memory: OrderMemory) -> Task | None:
    """An earlier life's task; None for a step."""
    match memory.kind:
        case Kind.PICK:
            return Pick(
                order=memory.number, station=memory.station, item=memory.item, quantity=memory.quantity
            )
        case Kind.DROP:
            return Drop(order=memory.number, station=memory.station, goal=memory.goal)
        case Kind.CHARGE:
            return Charge(order=memory.number, charger=memory.station)
    return None
