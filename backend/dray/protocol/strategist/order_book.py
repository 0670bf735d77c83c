"""The strategist's orders in work, and the goals that they were split into."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

from msgspec.structs import replace

from dray.memory import (
    WHOLE,
    EndedOrder,
    Memory,
    Note,
    OrderMemory,
    ReturnedOrder,
    StrategistMemory,
)
from dray.messages import OrderItem, OrderReleased, PartDefinition, Production
from dray.messages.gate import GoalHeld
from dray.plant import Plant
from dray.protocol.runtime.events import Commit
from dray.protocol.strategist.definitions import definition_for, part_definition, parts_of
from dray.protocol.strategist.order_in_work import OpenGoal as OpenGoal  # noqa: PLC0414 - told from here, too
from dray.protocol.strategist.order_in_work import OrderInWork as OrderInWork  # noqa: PLC0414

DELIVERY_S = 300.0
"""Time between the end of an order's goals and its due time (s): for carrying the last lot away."""

ORDERS_MAX = 50_000
"""Maximum orders in work, some 50 MB. More are refused; their senders repeat them."""

ENDED_KEPT = 131_072
"""Maximum ended orders whose repeated release is recognised, some 25 MB, and as many returned ones.

A gateway may not know yet that an order has ended, and sends it again; it must not be made twice. Every ten minutes
a gateway asks for all orders that it believes open, and without a gateway no orders come. So the orders that end
between two such requests are fewer than those in work and those of ten minutes.
"""


class OrderBook:
    """All orders of one plant, oldest first.

    Args:
        plant: its products, for orders without a definition.
        machines_for: the machines for a goal.
        life: suffix of goals' names, so that names differ between lives.
    """

    def __init__(self, plant: Plant, machines_for: Callable[[Production], Sequence[str]], life: str) -> None:
        self.held_with: Callable[[str], int] = lambda _order: 0  # Its epoch; 0 with only one strategist.
        self._plant = plant
        self._machines_for = machines_for
        self._life = life
        self._orders: dict[str, OrderInWork] = {}
        self._goals: dict[str, OpenGoal] = {}
        self._unclaimed: dict[str, dict[str, OpenGoal]] = {}
        """By product: goals without a machine."""
        self._ended: dict[str, EndedOrder] = {}
        """Orders that have ended, or were cancelled before they came, oldest first."""
        self._returned: dict[str, ReturnedOrder] = {}
        """Orders that were taken back and have not come again, oldest first."""
        self._count = 0
        """Number of goals ever named."""
        self._unwritten: dict[str, None] = {}
        """Names of notes to store; every order has one note."""

    def __iter__(self) -> Iterator[OpenGoal]:
        """All open goals, those of the oldest order first."""
        return (goal for order in self._orders.values() for goal in order.goals.values())

    def order(self, order: str) -> OrderInWork | None:
        """An order in work."""
        return self._orders.get(order)

    def knows(self, order: str, release: int) -> bool:
        """Whether this release is in work, has ended, or was taken back, perhaps before it came."""
        return (
            order in self._orders
            or order in self._ended
            or (order in self._returned and release <= self._returned[order].release)
        )

    def is_over(self, order: str) -> bool:
        """Whether an order has ended, or was taken back."""
        return order in self._ended or order in self._returned

    @property
    def is_full(self) -> bool:
        """Whether no more orders are accepted."""
        return len(self._orders) >= ORDERS_MAX

    def returned(self, order: str) -> ReturnedOrder | None:
        """How an order was taken back; None if it was not, or has come again since."""
        return self._returned.get(order)

    def goal(self, goal: str) -> OpenGoal | None:
        return self._goals.get(goal)

    def order_of(self, goal: OpenGoal) -> OrderInWork:
        """The order of an open goal."""
        return self._orders[goal.work.order]

    @property
    def in_work(self) -> int:
        """Number of orders in work."""
        return len(self._orders)

    def orders(self) -> list[OrderInWork]:
        """All orders in work, oldest first."""
        return list(self._orders.values())

    def ended(self, order: str) -> EndedOrder:
        """How an order has ended, as far as is known."""
        return self._ended.get(order, EndedOrder())

    def unclaimed(self, product: str) -> Iterator[OpenGoal]:
        """Goals of a product without a machine, the earliest deadline first."""
        return iter(sorted(self._unclaimed.get(product, {}).values(), key=lambda goal: goal.deadline_s))

    def can_be_made(self, item: OrderItem) -> bool:
        """Whether an item's product is known, and machines exist for it and all its parts."""
        work = self._work(item)
        if work is None or not self._machines_for(work):
            return False
        brought = {each.part: each.definition for each in item.parts}
        parts = parts_of(work.definition, brought, self._plant)
        return all(
            self._machines_for(
                replace(work, product=part, definition=part_definition(part, brought, self._plant))
            )
            for part in parts
        )

    # --- orders and goals ---

    def take(self, message: OrderReleased) -> OrderInWork:
        """Split a new order into goals."""
        # The goals have their own definitions.
        order = self._begin(message, tuple(replace(item, definition=None) for item in message.items))
        for index, item in enumerate(message.items):
            self.add_goals(order, index, item)
        return order

    def take_over(
        self, message: OrderReleased, arrived: Sequence[int], goals: Sequence[GoalHeld]
    ) -> OrderInWork:
        """Continue an order that another strategist has begun.

        Args:
            message: the last release.
            arrived: per item, the arrived pieces of all its goals ever; missing items have none.
            goals: the open goals. New ones are added for items without enough goals.
        """
        counts = [*arrived, *[0] * (len(message.items) - len(arrived))]
        wanted, admitted = [], [0] * len(counts)
        for held in goals:
            counts[held.of.item] -= held.arrived
            admitted[held.of.item] += held.admitted
        for item, count in zip(message.items, counts, strict=True):
            wanted.append(max(0, item.quantity + item.arrived - count))
        stands = [max(pair) for pair in zip(wanted, admitted, strict=True)]
        order = self._begin(
            message,
            tuple(
                replace(item, definition=None, quantity=quantity, arrived=count)
                for item, quantity, count in zip(message.items, stands, counts, strict=True)
            ),
        )
        order.wanted = wanted if stands != wanted else []
        for held in goals:
            index = held.of.item
            work = self._work(message.items[index], order.id, index)
            if work is None:
                continue
            goal = OpenGoal(held.goal, replace(work, quantity=held.admitted), order.due_s - DELIVERY_S)
            goal.machine, goal.epoch, goal.arrived = held.of.machine, held.of.epoch, held.arrived
            goal.to_begin -= held.arrived
            self._keep(order, goal)
        for index, item in enumerate(message.items):
            self.add_goals(order, index, replace(item, quantity=stands[index] - admitted[index]))
        return order

    def give_up(self, order: str) -> OrderInWork | None:
        """Forget an order that another strategist holds; None if it was not in work."""
        given_up = self._orders.pop(order, None)
        if given_up is not None:
            self._unwritten[order] = None
            for goal in given_up.goals.values():
                self._forget_goal(goal)
        return given_up

    def add_part(self, user: OpenGoal, part: str, pieces: int, deadline_s: float) -> list[OpenGoal]:
        """Add goals for at least `pieces` of a part that a goal lacks, in whole containers; returns them."""
        order = self.order_of(user)
        definition = part_definition(part, order.parts, self._plant)
        whole = -(-pieces // definition.lot) * definition.lot
        of = user.work.part_of or user.work.product
        work = Production(part, whole, order.id, user.work.item, definition, part_of=of)
        return [self._add(order, share, deadline_s) for share in self._shares(work)]

    def add_goals(self, order: OrderInWork, index: int, item: OrderItem) -> None:
        """Add goals for the pieces of an item."""
        for work in self._split(order.id, index, item):
            self._add(order, work, order.due_s - DELIVERY_S)

    def resize(self, order: OrderInWork, index: int, by: int) -> None:
        """Change the quantity of an item."""
        items = list(order.items)
        items[index] = replace(items[index], quantity=items[index].quantity + by)
        order.items = tuple(items)
        self._unwritten[order.id] = None

    def reduce(self, goal: OpenGoal, quantity: int) -> None:
        """Reduce the quantity of a goal."""
        self.resize(self._orders[goal.work.order], goal.work.item, quantity - goal.work.quantity)
        goal.work = replace(goal.work, quantity=quantity)

    def touch(self, order: OrderInWork) -> None:
        """Store another change of an order."""
        self._unwritten[order.id] = None

    def contract(self, goal: OpenGoal, machine: str, now_s: float) -> None:
        """A machine has taken a goal."""
        goal.machine, goal.waits, goal.taken_s = machine, False, now_s
        self._unclaimed[goal.work.product].pop(goal.id, None)
        self._unwritten[goal.work.order] = None

    def renew(self, goal: OpenGoal) -> None:
        """Invalidate an earlier life's announcement of a goal."""
        goal.epoch += 1
        self._unwritten[goal.work.order] = None

    def count(self, goal: OpenGoal, arrived: int) -> None:
        """Note the gate's count of a goal."""
        goal.arrived = arrived
        self._unwritten[goal.work.order] = None

    def revoke(self, order: OrderInWork, asker: str) -> None:
        """Take an order back for `asker`, who waits for its end."""
        order.revoked_by = asker
        self._unwritten[order.id] = None

    def succeed(self, goal: OpenGoal, quantity: int | None = None) -> OpenGoal:
        """Replace a goal by one for its missing pieces, or for another quantity."""
        order = self._orders[goal.work.order]
        self.close(goal)
        work = goal.work
        left = work.quantity - goal.arrived if quantity is None else quantity
        return self._add(order, replace(work, quantity=left), order.due_s - DELIVERY_S)

    def close(self, goal: OpenGoal) -> OrderInWork:
        """Forget a goal; returns its order."""
        order = self._orders[goal.work.order]
        self._forget_goal(goal)
        del order.goals[goal.id]
        self._unwritten[order.id] = None
        return order

    def withdraw(self, goal: OpenGoal) -> OrderInWork:
        """Forget a goal of an order that is taken back, and note its missing pieces; returns the order."""
        order = self.close(goal)
        order.withdrawn[goal.work.item] += goal.work.quantity - goal.arrived
        return order

    def give_back(self, order: str, release: int) -> ReturnedOrder:
        """Forget an order without open goals, or that never came: only a later release is accepted."""
        ended = self._orders.pop(order, None)
        outstanding = () if ended is None else tuple(ended.withdrawn)
        self._returned.pop(order, None)
        returned = self._returned[order] = ReturnedOrder(order, release, outstanding)
        self._unwritten[order] = None
        self._forget_oldest(self._returned)
        return returned

    def reopen(self, order: str) -> None:
        """Forget how an order has ended: its next release is taken."""
        self._ended.pop(order, None)
        self._returned.pop(order, None)
        self._unwritten[order] = None

    def close_order(self, order: str, *, fulfilled: bool = False) -> OrderInWork | None:
        """Forget an order and its goals, and accept none of this id any more.

        Args:
            order: its id.
            fulfilled: whether all of it has arrived; a later cancellation does not undo that.

        Returns:
            The order; None if it was not in work.
        """
        before, in_work = self.ended(order), self._orders.get(order)
        change = before.change if in_work is None else in_work.change
        quantities = in_work.quantities if in_work is not None and fulfilled else before.quantities
        self._ended[order] = EndedOrder(fulfilled or before.fulfilled, change, quantities)
        self._returned.pop(order, None)
        self._unwritten[order] = None
        self._forget_oldest(self._ended)
        ended = self._orders.pop(order, None)
        if ended is not None:
            for goal in ended.goals.values():
                self._forget_goal(goal)
        return ended

    # --- over a restart ---

    def commits(self) -> list[Commit]:
        """The changes since the last call, to store."""
        commits = [Commit(self._note(name), name) for name in self._unwritten]
        self._unwritten.clear()
        return commits

    def restore(self, memory: Memory) -> None:
        """Restore the notes of earlier lives."""
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
        order.parts = {each.part: each.definition for each in kept.parts}
        order.change, order.wanted = kept.change, list(kept.wanted)
        for booked in kept.goals:
            goal = OpenGoal(booked.goal, booked.work, booked.deadline_s)
            goal.machine, goal.epoch, goal.arrived = booked.machine, booked.epoch, booked.arrived
            goal.to_begin -= booked.arrived
            self._keep(order, goal)

    def _note(self, name: str) -> Note | None:
        """The note of an order, or of the whole book; None if the order is forgotten."""
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
            change=order.change,
            wanted=tuple(order.wanted),
            parts=tuple(PartDefinition(*each) for each in order.parts.items()),
        )

    def _forget_oldest(self, history: dict[str, EndedOrder] | dict[str, ReturnedOrder]) -> None:
        if len(history) > ENDED_KEPT:
            oldest = next(iter(history))
            del history[oldest]
            self._unwritten[oldest] = None

    # --- internals ---

    def _begin(self, message: OrderReleased, items: tuple[OrderItem, ...]) -> OrderInWork:
        order = OrderInWork(message.order, items, message.due_s, message.release)
        order.change = message.change
        order.parts = {each.part: each.definition for item in message.items for each in item.parts}
        self._orders[order.id] = order
        self._returned.pop(order.id, None)
        self._unwritten[order.id] = None
        return order

    def _add(self, order: OrderInWork, work: Production, deadline_s: float) -> OpenGoal:
        self._count += 1
        self._unwritten[WHOLE] = self._unwritten[order.id] = None
        goal = OpenGoal(f"{order.id}{self._life}-{work.item + 1}.{self._count}", work, deadline_s)
        self._keep(order, goal)
        return goal

    def _keep(self, order: OrderInWork, goal: OpenGoal) -> None:
        self._goals[goal.id] = order.goals[goal.id] = goal
        if not goal.machine:
            self._unclaimed.setdefault(goal.work.product, {})[goal.id] = goal

    def _forget_goal(self, goal: OpenGoal) -> None:
        del self._goals[goal.id]
        self._unclaimed.get(goal.work.product, {}).pop(goal.id, None)

    def _split(self, order: str, index: int, item: OrderItem) -> list[Production]:
        """Divide an item among its machines, in whole containers."""
        work = self._work(item, order, index)
        if work is None or not item.quantity:
            return []  # All of it was delivered before the order was released again.
        return self._shares(work)

    def _shares(self, work: Production) -> list[Production]:
        lot, machines = work.definition.lot, len(self._machines_for(work))
        lots = -(-work.quantity // lot)
        share = -(-lots // machines) * lot
        whole, rest = divmod(work.quantity, share)
        return [replace(work, quantity=pieces) for pieces in [share] * whole + ([rest] if rest else [])]

    def _work(self, item: OrderItem, order: str = "", index: int = 0) -> Production | None:
        """An item as one goal; None without a product definition."""
        definition = definition_for(item, self._plant)
        if definition is None:
            return None
        return Production(item.product, item.quantity, order, index, definition)
