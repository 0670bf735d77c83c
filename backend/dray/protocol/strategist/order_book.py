"""What the strategist has promised: orders in work and the goals that they were split into."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

from msgspec.structs import replace

from dray.memory import (
    WHOLE,
    EndedOrder,
    GoalBooked,
    Memory,
    Note,
    OrderMemory,
    ReturnedOrder,
    StrategistMemory,
)
from dray.messages import OrderItem, OrderReleased, Production, Reason
from dray.plant import Plant
from dray.protocol.runtime.events import Commit
from dray.protocol.strategist.definitions import definition_for

DELIVERY_S = 300.0
"""How long before an order is due its goals should be made: carrying the last lot away."""

ORDERS_MAX = 50_000
"""Orders in work, some 50 MB. More are not taken; whoever sends them repeats them."""

ENDED_KEPT = 131_072
"""Ended orders whose repeated release is still recognised, some 25 MB, and as many that were taken back.

A gateway that does not know yet that an order has ended sends it again, and it must not be made twice. Every ten
minutes a gateway asks for all orders that it believes open; and while none does, no orders come. So those that
end between two times that it has asked for one are less than what was in work then and what came in ten minutes.
"""


class OpenGoal:
    """A goal that is not delivered yet."""

    __slots__ = (
        "arrived",
        "brought",
        "deadline_s",
        "epoch",
        "failure",
        "id",
        "machine",
        "named_s",
        "offered",
        "waits",
        "work",
    )

    def __init__(self, goal: str, work: Production, deadline_s: float) -> None:
        self.id = goal
        self.work = work
        self.deadline_s = deadline_s
        self.machine = ""
        """Who makes it; empty while nobody has taken it."""
        self.epoch = 1
        """Of its announcement: one that an earlier life has made is not answered to any more."""
        self.arrived = 0
        """Pieces that the gate has counted."""
        self.brought: dict[str, int] = {}
        """The same by vehicle, as far as this life has heard it."""
        self.named_s = 0.0
        """When its machine has last said that it has this goal (plant clock)."""
        self.offered = False
        """Its machine asks that others make what is missing."""
        self.failure: Reason | None = None
        """Why it is being taken from its machine; the gate's last count is awaited."""
        self.waits = False
        """Whether it was said that nobody can make it."""

    def booked(self) -> GoalBooked:
        """What the next life must know of it."""
        return GoalBooked(
            goal=self.id,
            work=self.work,
            deadline_s=self.deadline_s,
            machine=self.machine,
            epoch=self.epoch,
            arrived=self.arrived,
        )


class OrderInWork:
    """An order that is not delivered yet."""

    __slots__ = ("due_s", "goals", "id", "items", "release", "revoked_by", "withdrawn")

    def __init__(self, order: str, items: tuple[OrderItem, ...], due_s: float, release: int) -> None:
        self.id = order
        self.items = items
        self.due_s = due_s
        self.release = release
        """How often it was released, with this time."""
        self.goals: dict[str, OpenGoal] = {}
        """Those that are not delivered."""
        self.revoked_by = ""
        """Who has taken it back: then it ends when no goal is open any more. Empty while it is worked at."""
        self.withdrawn = [0] * len(items)
        """Per item, pieces of goals that were withdrawn and had not arrived."""


class OrderBook:
    """All orders of one plant, oldest first.

    Args:
        plant: its products, for orders that bring no definition.
        machines_for: who can make a goal.
        life: marks the names of goals, so that no two lives give the same.
    """

    def __init__(self, plant: Plant, machines_for: Callable[[Production], Sequence[str]], life: str) -> None:
        self._plant = plant
        self._machines_for = machines_for
        self._life = life
        self._orders: dict[str, OrderInWork] = {}
        self._goals: dict[str, OpenGoal] = {}
        self._ended: dict[str, EndedOrder] = {}
        """Orders that have ended, or were cancelled before they came, oldest first."""
        self._returned: dict[str, ReturnedOrder] = {}
        """Orders that were taken back and have not come again, oldest first."""
        self._count = 0
        """Goals that were ever named."""
        self._unwritten: dict[str, None] = {}
        """Names of the notes that are not written down as they are now: an order has one, whatever it is."""

    def __iter__(self) -> Iterator[OpenGoal]:
        """All open goals, those of the oldest order first."""
        return (goal for order in self._orders.values() for goal in order.goals.values())

    def order(self, order: str) -> OrderInWork | None:
        """An order in work."""
        return self._orders.get(order)

    def knows(self, order: str, release: int) -> bool:
        """Whether this release is in work, or has ended or was taken back, if only before it came."""
        return (
            order in self._orders
            or order in self._ended
            or (order in self._returned and release <= self._returned[order].release)
        )

    def fulfilled(self, order: str) -> bool:
        """Whether an order has ended because all of it has arrived; False once that is forgotten."""
        return order in self._ended and self._ended[order].fulfilled

    @property
    def is_full(self) -> bool:
        """Whether no more orders are taken."""
        return len(self._orders) >= ORDERS_MAX

    def returned(self, order: str) -> ReturnedOrder | None:
        """How an order was taken back; None when it was not, or has come again since."""
        return self._returned.get(order)

    def goal(self, goal: str) -> OpenGoal | None:
        return self._goals.get(goal)

    def order_of(self, goal: OpenGoal) -> OrderInWork:
        """The order that an open goal is of."""
        return self._orders[goal.work.order]

    def revoked(self) -> Iterator[OrderInWork]:
        """Orders in work that are being taken back."""
        return (order for order in self._orders.values() if order.revoked_by)

    def unclaimed(self, product: str) -> Iterator[OpenGoal]:
        """Goals of a product that nobody has taken, in the order in which they are put up."""
        return (goal for goal in self if not goal.machine and goal.work.product == product)

    def can_be_made(self, item: OrderItem) -> bool:
        """Whether its product is known, and somebody can make it."""
        work = self._work(item)
        return work is not None and bool(self._machines_for(work))

    # --- orders and goals come and go ---

    def take(self, message: OrderReleased) -> OrderInWork:
        """Split a new order into goals."""
        # The goals have their definitions, once each.
        items = tuple(OrderItem(item.product, item.quantity) for item in message.items)
        order = OrderInWork(message.order, items, message.due_s, message.release)
        self._orders[order.id] = order
        self._returned.pop(order.id, None)
        self._unwritten[order.id] = None
        for index, item in enumerate(message.items):
            for work in self._split(order.id, index, item):
                self._add(order, work, message.due_s - DELIVERY_S)
        return order

    def contract(self, goal: OpenGoal, machine: str) -> None:
        """A machine has taken a goal."""
        goal.machine, goal.waits = machine, False
        self._unwritten[goal.work.order] = None

    def renew(self, goal: OpenGoal) -> None:
        """What an earlier life has announced of a goal is not answered to any more."""
        goal.epoch += 1
        self._unwritten[goal.work.order] = None

    def count(self, goal: OpenGoal, arrived: int) -> None:
        """The gate has counted so many pieces of a goal."""
        goal.arrived = arrived
        self._unwritten[goal.work.order] = None

    def revoke(self, order: OrderInWork, asker: str) -> None:
        """Somebody has taken an order back, and waits for its end."""
        order.revoked_by = asker
        self._unwritten[order.id] = None

    def succeed(self, goal: OpenGoal) -> OpenGoal:
        """Replace a goal by one for what has not arrived of it."""
        order = self._orders[goal.work.order]
        self.close(goal)
        work = goal.work
        rest = replace(work, quantity=work.quantity - goal.arrived)
        return self._add(order, rest, goal.deadline_s)

    def close(self, goal: OpenGoal) -> OrderInWork:
        """Forget a goal; returns its order."""
        order = self._orders[goal.work.order]
        del self._goals[goal.id], order.goals[goal.id]
        self._unwritten[order.id] = None
        return order

    def withdraw(self, goal: OpenGoal) -> OrderInWork:
        """Forget a goal of an order that is taken back, and note what has not arrived; returns the order."""
        order = self.close(goal)
        order.withdrawn[goal.work.item] += goal.work.quantity - goal.arrived
        return order

    def give_back(self, order: str, release: int) -> ReturnedOrder:
        """Forget an order that has no goals any more, or never came: only a later release is taken."""
        ended = self._orders.pop(order, None)
        outstanding = () if ended is None else tuple(ended.withdrawn)
        self._returned.pop(order, None)
        returned = self._returned[order] = ReturnedOrder(order, release, outstanding)
        self._unwritten[order] = None
        self._forget_oldest(self._returned)
        return returned

    def close_order(self, order: str, *, fulfilled: bool = False) -> OrderInWork | None:
        """Forget an order and its goals, and take none of this name any more.

        Args:
            order: which.
            fulfilled: whether all of it has arrived; no cancellation that comes later undoes that.

        Returns:
            The order; None when it was not in work.
        """
        self._ended[order] = EndedOrder(fulfilled=fulfilled or self.fulfilled(order))
        self._returned.pop(order, None)
        self._unwritten[order] = None
        self._forget_oldest(self._ended)
        ended = self._orders.pop(order, None)
        if ended is not None:
            for goal in ended.goals:
                del self._goals[goal]
        return ended

    # --- from life to life ---

    def commits(self) -> list[Commit]:
        """What has changed since this was asked for last, to be written down."""
        commits = [Commit(self._note(name), name) for name in self._unwritten]
        self._unwritten.clear()
        return commits

    def restore(self, memory: Memory) -> None:
        """Take up what earlier lives have written down."""
        for name, note in memory.items():
            if isinstance(note, StrategistMemory):
                self._count = note.goal_count
            elif isinstance(note, EndedOrder):
                self._ended[name] = note
            elif isinstance(note, ReturnedOrder):
                self._returned[name] = note
            elif isinstance(note, OrderMemory):
                self._restore_order(note)

    def _restore_order(self, kept: OrderMemory) -> None:
        order = self._orders[kept.order] = OrderInWork(kept.order, kept.items, kept.due_s, kept.release)
        order.revoked_by = kept.revoked_by
        order.withdrawn = list(kept.withdrawn) or order.withdrawn
        for booked in kept.goals:
            goal = OpenGoal(booked.goal, booked.work, booked.deadline_s)
            goal.machine, goal.epoch, goal.arrived = booked.machine, booked.epoch, booked.arrived
            self._goals[goal.id] = order.goals[goal.id] = goal

    def _note(self, name: str) -> Note | None:
        """What is to be written down of an order, or of none of them; None when it is forgotten."""
        if name == WHOLE:
            return StrategistMemory(goal_count=self._count)
        order = self._orders.get(name)
        if order is None:
            return self._returned.get(name) or self._ended.get(name)
        return OrderMemory(
            order=order.id,
            items=order.items,
            due_s=order.due_s,
            goals=tuple(goal.booked() for goal in order.goals.values()),
            release=order.release,
            revoked_by=order.revoked_by,
            withdrawn=tuple(order.withdrawn),
        )

    def _forget_oldest(self, history: dict[str, EndedOrder] | dict[str, ReturnedOrder]) -> None:
        if len(history) > ENDED_KEPT:
            oldest = next(iter(history))
            del history[oldest]
            self._unwritten[oldest] = None

    # --- how it is done ---

    def _add(self, order: OrderInWork, work: Production, deadline_s: float) -> OpenGoal:
        self._count += 1
        self._unwritten[WHOLE] = self._unwritten[order.id] = None
        goal = OpenGoal(f"{order.id}{self._life}-{work.item + 1}.{self._count}", work, deadline_s)
        self._goals[goal.id] = order.goals[goal.id] = goal
        return goal

    def _split(self, order: str, index: int, item: OrderItem) -> list[Production]:
        """Share an item among the machines that can make it, in whole containers."""
        work = self._work(item, order, index)
        if work is None or not item.quantity:
            return []  # All of it was delivered before the order was released again.
        lot, machines = work.definition.lot, len(self._machines_for(work))
        lots = -(-item.quantity // lot)
        share = -(-lots // machines) * lot
        whole, rest = divmod(item.quantity, share)
        return [replace(work, quantity=pieces) for pieces in [share] * whole + ([rest] if rest else [])]

    def _work(self, item: OrderItem, order: str = "", index: int = 0) -> Production | None:
        """All of an item as one goal; None when nobody has defined its product."""
        definition = definition_for(item, self._plant)
        if definition is None:
            return None
        return Production(item.product, item.quantity, order, index, definition)
