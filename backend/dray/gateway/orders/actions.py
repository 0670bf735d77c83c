"""Order actions: people's actions on an order after it was placed.

Each action is on disk before panels and the strategist hear of it.
"""

from __future__ import annotations

from collections.abc import Callable
from http import HTTPStatus

from dray.gateway.http.problems import Problem
from dray.gateway.live.projection import Projection
from dray.gateway.orders.outbox import Outbox
from dray.priorities import order_wanted_s
from dray.store import Store
from dray.store.orders.orders import Order
from dray.store.orders.progress import ENDED, OrderStatus


class OrderActions:
    """Releases, revokes and cancels orders.

    Args:
        store: the database with the orders.
        projection: shows the orders.
        outbox: tells the strategist.
        wall_s: the wall clock.
    """

    def __init__(
        self, store: Store, projection: Projection, outbox: Outbox, wall_s: Callable[[], float]
    ) -> None:
        self._store, self._projection, self._outbox, self._wall_s = store, projection, outbox, wall_s

    async def release(self, order_id: str) -> Order | None:
        """Release a stored order to the factory; an order released already stays as it is.

        Returns:
            The order now; None if it does not exist.

        Raises:
            Problem: 409, it was cancelled or is being taken back.
        """
        async with self._store.write() as work:
            before = await work.orders.get(order_id)
            if before is None:
                return None
            if before.status is OrderStatus.CANCELLED:
                raise _ended(before, "place it again")
            if before.being_revoked:
                raise Problem(
                    HTTPStatus.CONFLICT,
                    "being-taken-back",
                    "The order is being taken back",
                    f"the factory has not confirmed that it has stopped working at order {order_id}; "
                    "look at revoked_at_s and status, and try again when it is stored",
                    headers={"Retry-After": "1"},
                )
            now_s = self._wall_s()
            wanted_at_s = order_wanted_s(before.priority, now_s, before.due_at_s, self._projection.speed)
            await work.orders.release(order_id, now_s, wanted_at_s)
            after = await work.orders.get(order_id)
        if after is not None and before.status is OrderStatus.STORED:
            self._projection.orders.put(after)
            self._outbox.release(after)
        return after

    async def revoke(self, order_id: str) -> Order | None:
        """Take back an order's release; a stored order, or one being taken back, stays as it is.

        Returns:
            The order now: stored only once the factory has confirmed; None if it does not exist.

        Raises:
            Problem: 409, it has ended or is being changed.
        """
        async with self._store.write() as work:
            before = await work.orders.get(order_id)
            if before is None:
                return None
            if before.status in ENDED:
                raise _ended(before, "there is nothing left to take back")
            if before.being_changed:
                raise Problem(
                    HTTPStatus.CONFLICT,
                    "being-changed",
                    "The order is being changed",
                    f"the factory has not confirmed the last change of order {order_id}; try again when changing is false",
                    headers={"Retry-After": "1"},
                )
            await work.orders.revoke(order_id, self._wall_s())
            after = await work.orders.get(order_id)
        if after is not None and after.being_revoked and not before.being_revoked:
            self._projection.orders.put(after)
            self._outbox.revoke(after)
        return after

    async def cancel(self, order_id: str) -> Order | None:
        """Cancel an order; a cancelled one stays so.

        Returns:
            The order now; None if it does not exist.

        Raises:
            Problem: 409, it is delivered.
        """
        async with self._store.write() as work:
            before = await work.orders.get(order_id)
            if before is None:
                return None
            if before.status is OrderStatus.DELIVERED:
                raise _ended(before, "there is nothing left to cancel")
            await work.orders.cancel(order_id, self._wall_s())
            after = await work.orders.get(order_id)
        if after is not None and before.status is not OrderStatus.CANCELLED:
            self._projection.orders.put(after)
            self._outbox.cancel(order_id)
        return after


def _ended(order: Order, what_to_do: str) -> Problem:
    return Problem(
        HTTPStatus.CONFLICT,
        "order-ended",
        "The order has ended",
        f"order {order.id} is {order.status.value}; {what_to_do}",
    )
