"""The strategist: turns sales orders into production goals, and never decides a transport (paper, 3.2).

An order is split into goals, each goal is put up for auction among the machines that can make its
product, and what the machines say of their goals in their heartbeats is followed until all is
delivered. Goals of one product are auctioned one after another, so that every machine bids with
its real queue; different products at the same time.
"""

from __future__ import annotations

from collections import deque
from typing import cast

from dray.body import BodyState
from dray.memory import Memory
from dray.messages import (
    Accepted,
    Bid,
    Confirmed,
    Declined,
    GoalClosed,
    MachineHeartbeat,
    OrderCancelled,
    OrderItem,
    OrderReleased,
    OrderTaken,
    Production,
    Work,
)
from dray.messages.fact import GoalContracted, OrderAccepted, OrderDropped, OrderFulfilled
from dray.messages.keys import Keys
from dray.plant import Plant
from dray.protocol.auction import AuctionRules, Place
from dray.protocol.coordinator import Coordinator, OpenTask, Outcome
from dray.protocol.core import Core
from dray.protocol.events import Ignore, Record, Send
from dray.protocol.supervision import Following

STRATEGIST = "strategist"
"""The agent's id where a plant has one strategist."""

GOAL_RULES = AuctionRules(window_s=0.5, rest_s=5.0)
"""Machines are wired and few: the window may be shorter than for vehicles."""

DELIVERY_S = 300.0
"""How long before an order is due its goals should be made: carrying the last lot away."""

FULFILLED_KEPT = 1024
"""Ended orders whose repeated release is still recognised."""


class OrderInWork:
    """An order that is not delivered yet."""

    __slots__ = ("due_s", "goals", "id")

    def __init__(self, order: str, due_s: float, goals: tuple[str, ...]) -> None:
        self.id = order
        self.due_s = due_s
        self.goals = set(goals)
        """Those that are not delivered. Only ever asked for membership and emptiness."""


class Strategist(Core):
    """One plant's strategist.

    Args:
        plant: what can be made where.
        agent: its id.
        incarnation: how often it has been started; goals of an earlier life keep their names.
    """

    def __init__(self, plant: Plant, *, agent: str = STRATEGIST, incarnation: int = 1) -> None:
        super().__init__(agent, incarnation)
        self._plant = plant
        self._keys = Keys(plant.id)
        self._orders: dict[str, OrderInWork] = {}
        self._ended: dict[str, None] = {}
        """Ended orders, oldest first; a dict for its order."""
        self._waiting: dict[str, deque[tuple[str, Production, float]]] = {}
        """By product: goals that were not announced yet, with their deadlines."""
        self._asking: dict[str, str] = {}
        """By product: the goal that is up for auction."""
        self._machines = Following(self._keys.machine_heartbeat, self._out)
        self._goals = Coordinator(
            agent,
            # A goal's audience has no place: whoever can make the product is asked.
            Place(x_m=0.0, y_m=0.0, reach_m=0.0),
            self._audience,
            GOAL_RULES,
            self._timers,
            None,
            self._out,
            self._on_contracted,
        )
        self._on_message = {
            Bid: self._goals.hear_bid,
            Accepted: self._hear_accepted,
            Declined: self._goals.hear_declined,
            MachineHeartbeat: self._hear_machine,
            OrderReleased: self._hear_released,
            OrderCancelled: self._hear_cancelled,
        }
        self._on_alarm = self._goals.alarms

    def _start(self, body: BodyState | None, _memory: Memory | None, now_s: float) -> None:
        """Nothing is to be done before the first order comes."""

    # --- orders ---

    def _hear_released(self, sender: str, message: OrderReleased, now_s: float) -> None:
        if any(item.product not in self._plant.products for item in message.items):
            self._out.append(Ignore("an order for a product that this plant does not make"))
            return
        if message.order not in self._orders and message.order not in self._ended:
            self._begin(message, now_s)
        self._out.append(Send(sender, OrderTaken(order=message.order)))

    def _begin(self, message: OrderReleased, now_s: float) -> None:
        goals = [
            (index, number, item.product, quantity)
            for index, item in enumerate(message.items)
            for number, quantity in enumerate(self._split(item), start=1)
        ]
        life = "" if self.incarnation == 1 else f"r{self.incarnation}"
        names = tuple(f"{message.order}{life}-{index + 1}.{number}" for index, number, _, _ in goals)
        self._orders[message.order] = OrderInWork(message.order, message.due_s, names)
        self._out.append(Record(OrderAccepted(order=message.order, goals=names)))
        for name, (index, _, product, quantity) in zip(names, goals, strict=True):
            work = Production(product=product, quantity=quantity, order=message.order, item=index)
            waiting = self._waiting.setdefault(product, deque())
            waiting.append((name, work, message.due_s - DELIVERY_S))
        for item in message.items:
            self._ask_next(item.product, now_s)
        self._end_if_done(self._orders[message.order])

    def _split(self, item: OrderItem) -> list[int]:
        """Share an item among the machines that can make it, in whole containers."""
        if not item.quantity:
            return []  # All of it was delivered in an earlier life.
        lot = self._plant.products[item.product].lot
        machines = len(self._plant.machines_for(item.product))
        lots = -(-item.quantity // lot)
        share = -(-lots // machines) * lot
        whole, rest = divmod(item.quantity, share)
        return [share] * whole + ([rest] if rest else [])

    def _hear_cancelled(self, _sender: str, message: OrderCancelled, now_s: float) -> None:
        order = self._orders.pop(message.order, None)
        if order is None:
            return
        for product, waiting in self._waiting.items():
            self._waiting[product] = deque(goal for goal in waiting if goal[1].order != order.id)
        for task in list(self._goals):
            work = cast(Production, task.work)
            if work.order == order.id:
                self._close(task, "withdrawn")
                self._ask_next(work.product, now_s)
        self._remember(order.id)
        self._out.append(Record(OrderDropped(order=order.id)))

    # --- goals ---

    def _hear_accepted(self, sender: str, answer: Accepted, now_s: float) -> None:
        """Bind the machine, and confirm as often as it asks: it begins only then."""
        self._goals.hear_accepted(sender, answer, now_s)
        task = self._goals.get(answer.task)
        if task is not None and task.primary == sender and task.epoch == answer.epoch:
            self._out.append(Send(sender, Confirmed(task=task.id, epoch=task.epoch)))

    def _audience(self, work: Work, _radius_m: float) -> tuple[str, ...]:
        return (self._keys.goals(cast(Production, work).product),)

    def _ask_next(self, product: str, now_s: float) -> None:
        """Put the next goal of a product up for auction, unless one is."""
        waiting = self._waiting.get(product)
        if not waiting or product in self._asking:
            return
        goal, work, deadline_s = waiting.popleft()
        self._asking[product] = goal
        self._goals.open(goal, work, deadline_s, now_s)

    def _on_contracted(self, task: OpenTask, now_s: float) -> None:
        work = cast(Production, task.work)
        contracted = GoalContracted(
            goal=task.id,
            order=work.order,
            item=work.item,
            product=work.product,
            quantity=work.quantity,
            machine=task.primary,
            finish_s=task.promised_s,
        )
        self._out.append(Record(contracted))
        self._machines.begin(task.primary)
        self._asking.pop(work.product, None)
        self._ask_next(work.product, now_s)

    def _hear_machine(self, _sender: str, heartbeat: MachineHeartbeat, _now_s: float) -> None:
        for brief in heartbeat.goals:
            if brief.delivered < brief.quantity:
                continue
            task = self._goals.get(brief.goal)
            if task is not None:
                if task.primary == heartbeat.machine:
                    self._deliver(task)
            elif self._goals.closed(brief.goal) is not None:
                # The machine has not heard that its goal is closed.
                self._out.append(Send(heartbeat.machine, GoalClosed(goal=brief.goal)))

    def _deliver(self, task: OpenTask) -> None:
        self._out.append(Send(task.primary, GoalClosed(goal=task.id)))
        self._close(task, "delivered")
        order = self._orders.get(cast(Production, task.work).order)
        if order is not None:
            order.goals.discard(task.id)
            self._end_if_done(order)

    def _close(self, task: OpenTask, outcome: Outcome) -> None:
        if task.primary:
            self._machines.end(task.primary)
        product = cast(Production, task.work).product
        if self._asking.get(product) == task.id:
            del self._asking[product]
        self._goals.close(task, outcome)

    def _end_if_done(self, order: OrderInWork) -> None:
        if order.goals:
            return
        del self._orders[order.id]
        self._remember(order.id)
        self._out.append(Record(OrderFulfilled(order=order.id)))

    def _remember(self, order: str) -> None:
        self._ended[order] = None
        if len(self._ended) > FULFILLED_KEPT:
            del self._ended[next(iter(self._ended))]
