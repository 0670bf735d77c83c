"""One order of ours at a vehicle: what it says, how far it has come, and how it is written and remembered."""

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
    """What an order is for."""

    STEP = "step"
    PICK = "pick"
    DROP = "drop"
    CHARGE = "charge"


Task = Pick | Drop | Charge

Stop = tuple[str, Spot]
"""A node of an order, and where it lies."""

Place = tuple[int, int] | None
"""Of a node of an order in the agent's way: the number of the way, and the index there; None for no place."""


class VehicleOrder:
    """One order.

    Args:
        kind: what it is for.
        number: of the agent's instruction; reports carry it.
        stops: the nodes of its base; the vehicle is at the first one.
        beyond: those of its horizon.
        speeds_mps: the limit on the edge to each node, base and horizon; the first one's means nothing.
        action: what it does at its last node; None for a step.
        task: the instruction behind the action.
        corners: nodes of the plant that the vehicle does not know: its edges lead over them. Neither base nor horizon ends at one.

    Attributes:
        origin: the node that the vehicle left last, or stands at.
        ids: under which it was offered; the newest last.
        id: the one that the vehicle shows, else the newest.
        update: the number of the newest update.
        passed: how many of its base's nodes the vehicle has come past, less one: the index of the last one.
        places: for each node of the base its place in the agent's way.
        reason: why it has ended without success.
        is_unwanted: it is to be cancelled as soon as the vehicle has it.
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
        """Nodes of the base that the vehicle is known to have."""
        self.has_horizon = False
        """The vehicle is known to have a horizon, too: it is not idle before that is taken back."""
        self.from_node = 0
        """The first node of the newest update: the last one of the base before it."""
        self.passed = 0
        self.places: list[Place] = [None] * len(stops)
        self.states: States[OrderState] = States("an order", TRANSITIONS, OrderState.OFFERED)
        self.reason = ""
        self.old_errors: frozenset[tuple[str, str, tuple[str, ...]]] = frozenset()
        """What the vehicle complained of when it was offered, or warned of when it was extended: that refuses something else."""
        self.refused_with = ""
        """The words of its newest refusal in words."""
        self.ended_by: VehicleError | None = None
        """The error for which it was ended; None for none."""
        self.is_unwanted = False
        self.takes_updates = True
        self.is_twice = False
        """Its node is listed twice."""
        self.begun_s = 0.0
        """When it was offered first."""
        self.offered_s = self.said_s = 0.0
        self.retry_s = 0.0
        """When it may be offered again."""
        self.by_hand_s: float | None = None
        """So long its action may wait for a person; None where nobody is needed."""
        self.waits_since_s: float | None = None
        """Since when its action only waits."""
        self.acts_since_s: float | None = None
        """Since when the vehicle has it, and its action has not ended."""
        self.quiet_since_s: float | None = None
        """Since when the vehicle has nothing left to do, and the order is not done."""
        self.strangers = 0
        """States in a row that show another order."""

    @property
    def nodes(self) -> tuple[str, ...]:
        """Of its base, as the plant calls them: the first one may have another name in the order."""
        return (self.origin, *(stop[0] for stop in self.stops[1:]))

    @property
    def end(self) -> int:
        """The index of the last node of its base."""
        return len(self.stops) - 1

    @property
    def now(self) -> OrderState:
        return self.states.now

    def overdue(self, now_s: float, waiting_s: float) -> str:
        """Why its action is not waited for any longer; empty while it is.

        Args:
            now_s: the present time.
            waiting_s: so long an action may show that it waits.
        """
        if self.by_hand_s is not None:
            return NOBODY_LOADS if now_s - self.offered_s >= self.by_hand_s else ""
        waits = self.waits_since_s is not None and now_s - self.waits_since_s >= waiting_s
        return ONLY_WAITS if waits else ""

    def message(self) -> Order:
        """The newest update, as it is said; the same however often."""
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
        """What the next life must know of it."""
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

    def is_shown(self, state: State) -> bool:
        """Whether the vehicle shows it under any of its ids; one that has forgotten the id may show its action all the same."""
        if state.order_id and state.order_id in self.ids:
            return True
        return self.action is not None and state.action(self.action.id) is not None

    def place_in(self, state: State) -> int:
        """The index of the last node that was passed, by node and sequence number; never lower than it was."""
        nodes, node = self.nodes, state.last_node_id
        told = self._told(self.stops)
        by_number = (state.last_node_sequence_id or 0) // 2
        if 0 <= by_number < len(told) and nodes[told[by_number]] == node:
            return max(self.passed, told[by_number])
        # A vehicle whose sequence numbers are of no use.
        if nodes[self.passed] == node:
            return self.passed
        return next((i for i in range(self.passed + 1, len(nodes)) if nodes[i] == node), self.passed)

    def _told(self, points: list[Stop]) -> list[int]:
        """The indexes of those that are nodes of the order: all but corners."""
        return [index for index, (name, _) in enumerate(points) if index == 0 or name not in self._corners]


class Builder(Protocol):
    """Builds orders (`Steps`)."""

    @property
    def corners(self) -> Collection[str]:
        """Nodes that vehicles do not know."""

    def spot(self, node: str) -> Spot:
        """Where a node lies."""

    def action(self, task: Task, node: str, *, twice: bool | None = None) -> VehicleOrder:
        """An order for a task at a node."""


def restored(memory: OrderMemory, build: Builder) -> VehicleOrder:
    """An order of an earlier life: of a task the same in every word, since it may have to be said again.

    Args:
        memory: its nodes are the plant's.
        build: builds it as the earlier life has.
    """
    task = task_of(memory)
    if task is not None:
        order = build.action(task, memory.nodes[-1], twice=len(memory.nodes) > 1)
        if order.action is not None:
            order.action = msgspec.structs.replace(order.action, id=memory.action)
    else:
        stops = [(node, build.spot(node)) for node in memory.nodes]
        order = VehicleOrder(Kind.STEP, memory.number, stops, [], [None] * len(stops), corners=build.corners)
    order.id, order.update, order.ids = memory.id, memory.update, [memory.id]
    order.takes_updates = False
    return order


def task_of(memory: OrderMemory) -> Task | None:
    """What an earlier life was told to do; None for a step."""
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
