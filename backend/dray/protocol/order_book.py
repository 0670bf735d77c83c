"""What the strategist has promised: orders in work and the goals that they were split into."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

from dray.memory import GoalBooked, OrderMemory, ReturnedOrder, StrategistMemory
from dray.messages import OrderItem, OrderReleased, Production
from dray.plant import Plant
from dray.protocol.newest import Newest

DELIVERY_S = 300.0
"""How long before an order is due its goals should be made: carrying the last lot away."""

ENDED_KEPT = 1024
"""Ended orders whose repeated release is still recognised; as many that were taken back."""


class OpenGoal:
    """A goal that is not delivered yet."""

    __slots__ = (
        "arrived",
        "deadline_s",
        "epoch",
        "failure",
        "id",
        "machine",
        "named_s",
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
        self.named_s = 0.0
        """When its machine has last said that it has this goal (plant clock)."""
        self.failure = ""
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
        plant: what can be made of what.
        machines_for: who can make a product.
        life: marks the names of goals, so that no two lives give the same.
    """

    def __init__(self, plant: Plant, machines_for: Callable[[str], Sequence[str]], life: str) -> None:
        self._plant = plant
        self._machines_for = machines_for
        self._life = life
        self._orders: dict[str, OrderInWork] = {}
        self._goals: dict[str, OpenGoal] = {}
        self._ended: Newest[str, bool] = Newest(ENDED_KEPT)
        """Orders that have ended, or were cancelled before they came, oldest first: whether all of it has arrived."""
        self._returned: Newest[str, ReturnedOrder] = Newest(ENDED_KEPT)
        """Orders that were taken back and have not come again, oldest first."""
        self._count = 0
        """Goals that were ever named."""

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
        return self._ended.get(order, False)

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

    # --- orders and goals come and go ---

    def take(self, message: OrderReleased) -> OrderInWork:
        """Split a new order into goals."""
        order = OrderInWork(message.order, message.items, message.due_s, message.release)
        self._orders[order.id] = order
        self._returned.pop(order.id, None)
        for index, item in enumerate(message.items):
            for quantity in self._split(item):
                work = Production(product=item.product, quantity=quantity, order=order.id, item=index)
                self._add(order, work, message.due_s - DELIVERY_S)
        return order

    def succeed(self, goal: OpenGoal) -> OpenGoal:
        """Replace a goal by one for what has not arrived of it."""
        order = self._orders[goal.work.order]
        self.close(goal)
        work = goal.work
        rest = Production(
            product=work.product,
            quantity=work.quantity - goal.arrived,
            order=work.order,
            item=work.item,
        )
        return self._add(order, rest, goal.deadline_s)

    def close(self, goal: OpenGoal) -> OrderInWork:
        """Forget a goal; returns its order."""
        order = self._orders[goal.work.order]
        del self._goals[goal.id], order.goals[goal.id]
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
        return returned

    def end(self, order: str, *, fulfilled: bool = False) -> OrderInWork | None:
        """Forget an order and its goals, and take none of this name any more.

        Args:
            order: which.
            fulfilled: whether all of it has arrived; no cancellation that comes later undoes that.

        Returns:
            The order; None when it was not in work.
        """
        self._ended[order] = fulfilled or self.fulfilled(order)
        self._returned.pop(order, None)
        ended = self._orders.pop(order, None)
        if ended is not None:
            for goal in ended.goals:
                del self._goals[goal]
        return ended

    # --- from life to life ---

    def memory(self) -> StrategistMemory:
        """All of it, to be written down."""
        orders = tuple(
            OrderMemory(
                order=order.id,
                items=order.items,
                due_s=order.due_s,
                goals=tuple(goal.booked() for goal in order.goals.values()),
                release=order.release,
                revoked_by=order.revoked_by,
                withdrawn=tuple(order.withdrawn),
            )
            for order in self._orders.values()
        )
        return StrategistMemory(
            orders=orders,
            ended=tuple(self._ended),
            goal_count=self._count,
            returned=tuple(self._returned.values()),
            fulfilled=tuple(order for order, fulfilled in self._ended.items() if fulfilled),
        )

    def restore(self, memory: StrategistMemory) -> None:
        """Take up what an earlier life has written down."""
        fulfilled = frozenset(memory.fulfilled)
        self._ended.update({order: order in fulfilled for order in memory.ended})
        self._count = memory.goal_count
        self._returned.update({kept.order: kept for kept in memory.returned})
        for kept in memory.orders:
            order = self._orders[kept.order] = OrderInWork(kept.order, kept.items, kept.due_s, kept.release)
            order.revoked_by = kept.revoked_by
            order.withdrawn = list(kept.withdrawn) or order.withdrawn
            for booked in kept.goals:
                goal = OpenGoal(booked.goal, booked.work, booked.deadline_s)
                goal.machine, goal.epoch, goal.arrived = booked.machine, booked.epoch, booked.arrived
                self._goals[goal.id] = order.goals[goal.id] = goal

    # --- how it is done ---

    def _add(self, order: OrderInWork, work: Production, deadline_s: float) -> OpenGoal:
        self._count += 1
        goal = OpenGoal(f"{order.id}{self._life}-{work.item + 1}.{self._count}", work, deadline_s)
        self._goals[goal.id] = order.goals[goal.id] = goal
        return goal

    def _split(self, item: OrderItem) -> list[int]:
        """Share an item among the machines that can make it, in whole containers."""
        if not item.quantity:
            return []  # All of it was delivered before the order was released again.
        lot = self._plant.products[item.product].lot
        machines = len(self._machines_for(item.product))
        lots = -(-item.quantity // lot)
        share = -(-lots // machines) * lot
        whole, rest = divmod(item.quantity, share)
        return [share] * whole + ([rest] if rest else [])
