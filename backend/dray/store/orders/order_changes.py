"""Changes of orders in SQL: what people ask for, and what the factory has made of it.

More of an item is ordered at once, so nothing of it counts as all before the strategist has said so. Less is only wanted (`order_items.wanted`)
until machines have said what they keep. While a change is under way its order has not ended, whatever facts tell.
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
    """An order as it is to be."""

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
        """Keep what an order is to be; one that is in work is changed when the strategist has answered.

        Args:
            order: as it was read in this transaction, not ended.
            change: what it is to be.
            at_s: when people said so.
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
        """The strategist has taken a change, or all changes came too late.

        Args:
            order_id: which; one that was changed again, or released again, stays as it is.
            release: which release it speaks of.
            change: the last one that it has taken; all later ones have come too late if the order is fulfilled.
            quantities: per item, all that will have been delivered; empty for as many as were ordered before.
            at_s: when it said so.

        Returns:
            Whether this has ended a change.
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
