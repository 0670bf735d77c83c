"""How a strategist drops a cancelled order, or takes one back.

An order that is taken back ends when the gate is shut for all of its goals; the gate's count by then is final.
"""

from __future__ import annotations

from dray.body import Admit
from dray.body.gate import EVERY_RELEASE
from dray.messages import (
    CancellationTaken,
    OrderCancelled,
    OrderReleased,
    OrderRevoked,
    Reason,
    RevocationTaken,
)
from dray.messages.fact import GoalWithdrawn, OrderDropped
from dray.messages.overtaken import LatestNumbers
from dray.protocol.runtime.life import Life
from dray.protocol.strategist.goal_auctions import GoalAuctions
from dray.protocol.strategist.order_book import ORDERS_MAX, OpenGoal, OrderBook, OrderInWork
from dray.protocol.strategist.order_ends import OrderEnds
from dray.protocol.strategist.part_goals import PartGoals

ENDS_KEPT = 1_000
"""Ends whose time is remembered, more than come in 35 s; the time of a forgotten one counts anew."""


class OrderRevocations:
    """The revocations of one strategist.

    Args:
        book: all orders and goals.
        auctions: those of the goals.
        parts: goals of parts.
        ends: ends goals and orders.
    """

    def __init__(
        self,
        book: OrderBook,
        auctions: GoalAuctions,
        parts: PartGoals,
        ends: OrderEnds,
        life: Life,
    ) -> None:
        self._book, self._auctions, self._parts = book, auctions, parts
        self._ends, self._life = ends, life
        self._releases: LatestNumbers[str] = LatestNumbers(ORDERS_MAX)
        """By order in work: its release."""
        self._over: LatestNumbers[str] = LatestNumbers(ENDS_KEPT)
        """By order that was cancelled or taken back: the last release that has ended by that."""

    def on_released(self, message: OrderReleased, now_s: float) -> None:
        """An order is released: forget an end of it that its gateways do not know of.

        Gateways release no order that people have cancelled, nor an earlier release than was taken back. If one still does when no late message
        can say so, a thief of a gateway's certificate has ended the order.
        """
        name, said = message.order, (message.release,)
        order, returned = self._book.order(name), self._book.returned(name)
        if order is not None:
            if message.release == order.release:
                self._releases.of(name, said, now_s).stands(said, now_s)
            return
        if returned is not None:
            over = (returned.release,)
        elif self._book.is_over(name) and not self._book.ended(name).fulfilled:
            over = (EVERY_RELEASE,)
        else:
            return
        newest = self._over.of(name, over, now_s)
        if said < over and not newest.overtakes(said, now_s):
            self._ends.reopen(name, message.release)

    def on_cancelled(self, sender: str, message: OrderCancelled, now_s: float) -> None:
        """Drop an order, and answer every request, even for an order that has not come yet."""
        if (order := self._book.order(message.order)) is not None:
            self._drop(order, now_s)
        else:
            self._book.close_order(message.order)
        self._over.of(message.order, (EVERY_RELEASE,), now_s).stands((EVERY_RELEASE,), now_s)
        self._ends.tell(message.order, EVERY_RELEASE)
        self._life.send(sender, CancellationTaken(order=message.order))

    def _drop(self, order: OrderInWork, now_s: float) -> None:
        products = dict.fromkeys(goal.work.product for goal in order.goals.values())
        self._parts.withdraw(order)
        self._book.close_order(order.id)
        for goal in order.goals.values():
            if goal.machine:
                # From now on the gate is shut for it, as for any goal without a machine.
                self._life.instruct(Admit(goal=goal.id, quantity=0))
            self._auctions.close_goal(goal, "withdrawn")
        for product in products:
            self._auctions.ask_next(product, now_s)
        self._life.record(OrderDropped(order=order.id))

    def on_revoked(self, sender: str, message: OrderRevoked, now_s: float) -> None:
        """Take an order back, and answer every request when the gate is shut for all of it."""
        order = self._book.order(message.order)
        said = (message.release,)
        if order is None:
            self._answer(sender, message)
            if (
                returned := self._book.returned(message.order)
            ) is not None and returned.release == message.release:
                self._over.of(message.order, said, now_s).stands(said, now_s)
            return
        newest = self._releases.of(order.id, (order.release,), now_s)
        if message.release < order.release and not newest.overtakes(said, now_s):
            # Nobody releases the later one any more: a thief of a gateway's certificate has stated it.
            order.release = message.release
        if message.release != order.release:
            self._life.ignore("a revocation of another release of an order")
        elif not order.revoked_by:
            self._book.revoke(order, sender)
            self.shut(order)
            for item in order.items:
                self._auctions.ask_next(item.product, now_s)

    def shut(self, order: OrderInWork) -> None:
        """Withdraw goals without a machine, and shut the gate for the others, whose last count is awaited."""
        self._parts.withdraw(order)
        for goal in list(order.goals.values()):
            if goal.machine:
                goal.failure = goal.failure or Reason.WITHDRAWN
                self._life.instruct(Admit(goal=goal.id, quantity=0))
            else:
                self._auctions.close_goal(goal, "withdrawn")
                self._book.withdraw(goal)
        self._ends.end_if_done(order)

    def take_out(self, goal: OpenGoal) -> None:
        """The gate is shut and has counted: end a goal of an order that was taken back."""
        self._auctions.close_goal(goal, "withdrawn")
        order = self._book.withdraw(goal)
        held = self._book.held_with(order.id)
        self._life.record(GoalWithdrawn(goal.id, goal.machine, goal.arrived, held))
        self._ends.end_if_done(order)

    def _answer(self, asker: str, message: OrderRevoked) -> None:
        """Repeat how an order was taken back; one that has not come will not be begun."""
        outstanding: tuple[int, ...] = ()
        returned = self._book.returned(message.order)
        if not self._book.knows(message.order, message.release):
            self._book.give_back(message.order, message.release)
            self._ends.tell(message.order, message.release)
        elif returned is not None and returned.release == message.release:
            outstanding = returned.outstanding
        self._life.send(asker, RevocationTaken(message.order, message.release, outstanding))
