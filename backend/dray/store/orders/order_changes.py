"""Changes of orders in SQL: people's wishes, and the factory's answers.

An increase takes effect at once, so that the order is not complete before the strategist's answer. A decrease is only noted
(`order_items.wanted`) until machines have reported what they keep. During a change its order does not end, whatever facts say.
"""

from __future__ import annotations

from collections.abc import Sequence

import msgspec
from sqlalchemy import update
from sqlalchemy.ext.asyncio import AsyncConnection

from dray.priorities import Priority
from dray.store.orders.orders import Order, Orders, search_of
from dray.store.orders.progress import OPEN
from dray.store.tables import order_items, orders


class Change(msgspec.Struct, frozen=True, kw_only=True):
    """The wanted state of an order."""

    quantities: tuple[int, ...]
    reference: str | None
    due_at_s: float | None
    priority: Priority
    wanted_at_s: float | None


class OrderChanges:
    """Changes, inside one transaction."""

    def __init__(self, connection: AsyncConnection) -> None:
        self._connection, self._orders = connection, Orders(connection)

    async def ask(self, order: Order, change: Change, at_s: float) -> None:
        """Store a change; an order in work is changed after the strategist's answer.

        Args:
            order: as read in this transaction, not ended.
            change: the wanted state.
            at_s: the time of the wish.
        """
        number = order.change + 1
        in_work = order.status in OPEN
        await self._connection.execute(
            update(orders)
            .where(orders.c.id == order.id)
            .values(
                reference=change.reference,
                due_at_s=change.due_at_s,
                priority=change.priority.value,
                wanted_at_s=change.wanted_at_s,
                change=number,
                change_taken=order.change_taken if in_work else number,
                updated_at_s=at_s,
                search=search_of(msgspec.structs.replace(order, reference=change.reference)),
            )
        )
        for index, (item, quantity) in enumerate(zip(order.items, change.quantities, strict=True)):
            less = in_work and quantity < item.quantity
            await self._put(order.id, index, item.quantity if less else quantity, quantity if less else None)

    async def settle(
        self, order_id: str, release: int, change: int, quantities: Sequence[int], at_s: float
    ) -> bool:
        """The strategist has accepted a change, or all changes came too late.

        Args:
            order_id: the order; one that was changed again, or released again, stays as it is.
            release: the release concerned.
            change: the last accepted one; if the order is fulfilled, all later ones have come too late.
            quantities: per item, the total to be delivered; empty for the previous quantities.
            at_s: the time of the answer.

        Returns:
            Whether a change has ended by this.
        """
        order = await self._orders.get(order_id)
        if order is None or not order.being_changed or order.releases != release or change > order.change:
            return False
        settled = quantities or order.quantities
        if len(settled) != len(order.items):
            return False
        for index, quantity in enumerate(settled):
            if quantity:
                await self._put(order_id, index, quantity, None)
        taken = update(orders).where(orders.c.id == order_id)
        await self._connection.execute(taken.values(change_taken=order.change, updated_at_s=at_s))
        return True

    async def _put(self, order_id: str, index: int, quantity: int, wanted: int | None) -> None:
        line = update(order_items).where(order_items.c.order_id == order_id, order_items.c.item == index)
        await self._connection.execute(line.values(quantity=quantity, wanted=wanted))
