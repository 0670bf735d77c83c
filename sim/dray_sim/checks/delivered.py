"""Invariant 4: an ordered quantity is delivered exactly once, counted where goods leave the factory.

The count is the gate's own, over all goals that an item of an order ever had. Neither the makers of the pieces nor
failures of machines or the strategist make a difference.
"""

from __future__ import annotations

from collections.abc import Callable

from msgspec.structs import replace

from dray.messages import Event, Message, OrderReleased, OrderTaken, Production
from dray.messages.fact import (
    GoalReduced,
    GoodsDelivered,
    OrderChanged,
    OrderDropped,
    OrderFulfilled,
    TaskClosed,
    TaskOpened,
)
from dray.protocol.strategist.order_book import ENDED_KEPT
from dray_sim.checks.broken import InvariantBroken


class Ordered:
    """One order: its quantities, and its goals by item."""

    __slots__ = ("change", "goals", "quantities")

    def __init__(self, quantities: list[int]) -> None:
        self.quantities = quantities
        self.change = 0
        self.goals: list[dict[str, None]] = [{} for _ in quantities]


class DeliveredExactly:
    """Never more than was ordered, and exactly that when an order is fulfilled, or said to be so.

    Args:
        arrived: how many pieces of a goal are in.
    """

    hears = (Event, OrderReleased, OrderTaken)

    def __init__(self, arrived: Callable[[str], int]) -> None:
        self._arrived = arrived
        self._orders: dict[str, Ordered] = {}
        """Orders that have not ended; bounded by the work in progress."""
        self._work: dict[str, Production] = {}
        """The work of the goals of those orders."""
        self._fulfilled: dict[str, None] = {}
        """Orders of which all has arrived, oldest first: as many as the strategist can still speak of."""

    def on_message(self, at_s: float, _sender: str, _address: str, message: Message) -> None:
        if type(message) is Event:
            fact = message.fact
            if type(fact) is GoodsDelivered:
                self._check_count(fact, at_s)
            elif type(fact) is TaskClosed and fact.task in self._work and fact.outcome == "delivered":
                self._check_goal(fact.task, at_s)
            elif type(fact) is TaskOpened:
                if type(fact.work) is Production and not fact.work.part_of:
                    self._note_goal(fact.task, fact.work)
            elif type(fact) is OrderFulfilled:
                self._check_order(fact.order, at_s)
                self._forget(fact.order)
                self._note_fulfilled(fact.order)
            elif type(fact) is GoalReduced or type(fact) is OrderChanged:
                self._note_change(fact)
            elif type(fact) is OrderDropped:
                self._forget(fact.order)
        elif type(message) is OrderReleased:
            self._note_order(message)
        elif type(message) is OrderTaken and message.fulfilled and message.order not in self._fulfilled:
            raise InvariantBroken(4, at_s, f"{message.order} was said to be fulfilled, and was not")

    def _note_order(self, message: OrderReleased) -> None:
        # The message is repeated until it is answered, and later holds less than was ordered.
        asked = [item.quantity + item.arrived for item in message.items]
        order = self._orders.setdefault(message.order, Ordered(asked))
        if message.change > order.change:
            # Until the machines have told what they keep, either quantity is possible.
            order.change = message.change
            order.quantities = [max(pair) for pair in zip(order.quantities, asked, strict=True)]

    def _note_change(self, fact: GoalReduced | OrderChanged) -> None:
        if isinstance(fact, GoalReduced):
            if fact.goal in self._work:
                self._work[fact.goal] = replace(self._work[fact.goal], quantity=fact.quantity)
        elif (order := self._orders.get(fact.order)) is not None and fact.change == order.change:
            order.quantities = list(fact.quantities)

    def _note_goal(self, goal: str, work: Production) -> None:
        order = self._orders.get(work.order)
        if order is not None:
            order.goals[work.item][goal] = None
            self._work[goal] = work

    def _check_count(self, fact: GoodsDelivered, at_s: float) -> None:
        arrived = self._arrived(fact.goal)
        if fact.delivered > arrived:
            seen = f"{fact.goal}: {fact.delivered} pieces were counted, {arrived} are in"
            raise InvariantBroken(4, at_s, seen)
        order = self._orders.get(fact.order)
        if order is not None:
            self._check_item(fact.order, order, fact.item, at_s, exactly=False)

    def _check_goal(self, goal: str, at_s: float) -> None:
        arrived, wanted = self._arrived(goal), self._work[goal].quantity
        if arrived != wanted:
            raise InvariantBroken(4, at_s, f"{goal} was closed with {arrived} of {wanted} pieces")

    def _check_order(self, name: str, at_s: float) -> None:
        order = self._orders.get(name)
        if order is not None:
            for item in range(len(order.quantities)):
                self._check_item(name, order, item, at_s, exactly=True)

    def _check_item(self, name: str, order: Ordered, item: int, at_s: float, *, exactly: bool) -> None:
        arrived, ordered = sum(map(self._arrived, order.goals[item])), order.quantities[item]
        if arrived > ordered or (exactly and arrived != ordered):
            seen = f"item {item + 1} of {name}: {arrived} pieces are in, {ordered} were ordered"
            raise InvariantBroken(4, at_s, seen)

    def _note_fulfilled(self, name: str) -> None:
        self._fulfilled[name] = None
        if len(self._fulfilled) > ENDED_KEPT:
            del self._fulfilled[next(iter(self._fulfilled))]

    def _forget(self, name: str) -> None:
        order = self._orders.pop(name, None)
        for goals in order.goals if order is not None else ():
            for goal in goals:
                del self._work[goal]
