"""How a strategist ends goals and orders: an order ends when none of its goals is open any more."""

from __future__ import annotations

from dray.body.gate import EVERY_RELEASE
from dray.messages import GoalClosed, RevocationTaken
from dray.messages.fact import OrderChanged, OrderFulfilled, OrderReturned
from dray.protocol.runtime.life import Life
from dray.protocol.strategist.goal_auctions import GoalAuctions
from dray.protocol.strategist.order_book import OpenGoal, OrderBook, OrderInWork
from dray.protocol.strategist.part_goals import PartGoals
from dray.protocol.strategist.shared_orders import SharedOrders


class OrderEnds:
    """The ends of one strategist's goals and orders.

    Args:
        book: all orders and goals.
        auctions: those of the goals.
        parts: goals of parts.
        shared: the orders shared with other strategists; None if there are no others.
    """

    def __init__(
        self,
        book: OrderBook,
        auctions: GoalAuctions,
        parts: PartGoals,
        shared: SharedOrders | None,
        life: Life,
    ) -> None:
        self._book, self._auctions, self._parts = book, auctions, parts
        self._shared, self._life = shared, life

    def deliver(self, goal: OpenGoal) -> None:
        """All wanted pieces of a goal have arrived."""
        self._life.send(goal.machine, GoalClosed(goal=goal.id))
        self._auctions.close_goal(goal, "delivered")
        self.close(goal)

    def close(self, goal: OpenGoal) -> None:
        """Nothing of a goal is wanted any more, and its auction is closed: its order may end, too."""
        self.end_if_done(self._book.close(goal))

    def end_if_done(self, order: OrderInWork) -> None:
        """End an order if no goal of it is open."""
        if not order.is_delivered:
            return
        self.end_change(order)
        self._parts.withdraw(order)
        if any(order.withdrawn):
            returned = self._book.give_back(order.id, order.release)
            self._life.record(OrderReturned(order.id, order.release, returned.outstanding))
        else:
            self._book.close_order(order.id, fulfilled=True)
            self._life.record(OrderFulfilled(order=order.id))
        self.tell(order.id, order.release if any(order.withdrawn) else EVERY_RELEASE)
        if order.revoked_by:
            taken = RevocationTaken(order.id, order.release, tuple(order.withdrawn))
            self._life.send(order.revoked_by, taken)

    def end_change(self, order: OrderInWork) -> None:
        """End a change under way: the order stays as it is now."""
        if order.wanted:
            order.wanted = []
            self._book.touch(order)
            changed = OrderChanged(order.id, order.release, order.change, order.quantities)
            self._life.record(changed)

    def reopen(self, order: str, release: int) -> None:
        """Forget how an order has ended: this release of it is made."""
        self._book.reopen(order)
        if self._shared is not None:
            self._shared.is_made_again(order, release)

    def tell(self, order: str, release: int) -> None:
        """Have the gate told, for later holders, that an order has ended, up to this release."""
        if self._shared is not None:
            self._shared.has_ended(order, release)
