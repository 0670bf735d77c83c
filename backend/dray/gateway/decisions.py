"""Decisions: what people do with an order after it was placed.

Each is on disk before panels and the strategist hear of it.
"""

from __future__ import annotations

from http import HTTPStatus

from dray.gateway.parts import Parts
from dray.gateway.problems import Problem
from dray.store.orders import Order
from dray.store.progress import ENDED, OrderStatus


async def release(gateway: Parts, order_id: str) -> Order | None:
    """Hand a stored order to the factory; one that is there already stays as it is.

    Returns:
        The order as it is now; None when there is none.

    Raises:
        Problem: 409, it has ended.
    """
    async with gateway.store.write() as work:
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
        await work.orders.release(order_id, gateway.wall_s())
        after = await work.orders.get(order_id)
    if after is not None and before.status is OrderStatus.STORED:
        gateway.projection.orders.put(after)
        gateway.desk.release(after)
    return after


async def revoke(gateway: Parts, order_id: str) -> Order | None:
    """Take the start of an order back; one that is stored, or being taken back, stays as it is.

    Returns:
        The order as it is now: stored only when the factory has confirmed; None when there is none.

    Raises:
        Problem: 409, it has ended.
    """
    async with gateway.store.write() as work:
        before = await work.orders.get(order_id)
        if before is None:
            return None
        if before.status in ENDED:
            raise _ended(before, "there is nothing left to take back")
        await work.orders.revoke(order_id, gateway.wall_s())
        after = await work.orders.get(order_id)
    if after is not None and after.being_revoked and not before.being_revoked:
        gateway.projection.orders.put(after)
        gateway.desk.revoke(after)
    return after


async def cancel(gateway: Parts, order_id: str) -> Order | None:
    """Cancel an order; one that is cancelled already stays so.

    Returns:
        The order as it is now; None when there is none.

    Raises:
        Problem: 409, it is delivered.
    """
    async with gateway.store.write() as work:
        before = await work.orders.get(order_id)
        if before is None:
            return None
        if before.status is OrderStatus.DELIVERED:
            raise _ended(before, "there is nothing left to cancel")
        await work.orders.cancel(order_id, gateway.wall_s())
        after = await work.orders.get(order_id)
    if after is not None and before.status is not OrderStatus.CANCELLED:
        gateway.projection.orders.put(after)
        gateway.desk.cancel(order_id)
    return after


def _ended(order: Order, what_to_do: str) -> Problem:
    return Problem(
        HTTPStatus.CONFLICT,
        "order-ended",
        "The order has ended",
        f"order {order.id} is {order.status.value}; {what_to_do}",
    )
