"""Which orders a list is asked for."""

from __future__ import annotations

from collections.abc import Collection, Iterator

import msgspec
from sqlalchemy import ColumnElement, exists

from dray.store.orders.progress import OrderStatus
from dray.store.tables import order_items, orders


class OrderFilter(msgspec.Struct, frozen=True, kw_only=True):
    """Which orders are wanted; empty fields want all. Times are wall clock seconds."""

    statuses: Collection[OrderStatus] = ()
    reference: str = ""
    """This very text, as the two below."""
    customer: str = ""
    product: str = ""
    """The id of a product of which it has a line."""
    updated_since_s: float | None = None
    """Changed at this moment or later."""
    due_before_s: float | None = None
    """One without a due time is due before none."""

    def conditions(self) -> Iterator[ColumnElement[bool]]:
        """What a row of `orders` has to fulfil."""
        if self.statuses:
            yield orders.c.status.in_(self.statuses)
        if self.reference:
            yield orders.c.reference == self.reference
        if self.customer:
            yield orders.c.customer == self.customer
        if self.product:
            line = (order_items.c.order_id == orders.c.id) & (order_items.c.product == self.product)
            yield exists().where(line)
        if self.updated_since_s is not None:
            yield orders.c.updated_at_s >= self.updated_since_s
        if self.due_before_s is not None:
            yield orders.c.due_at_s < self.due_before_s


EVERY_ORDER = OrderFilter()
