"""The filter of a list of orders."""

from __future__ import annotations

from collections.abc import Collection, Iterator

import msgspec
from sqlalchemy import ColumnElement, exists, func, or_

from dray.store.database.searching import Sought
from dray.store.orders.progress import OrderStatus
from dray.store.tables import order_items, orders


class OrderFilter(msgspec.Struct, frozen=True, kw_only=True):
    """A filter for orders; empty fields match all. Times are wall clock seconds."""

    statuses: Collection[OrderStatus] = ()
    reference: str = ""
    """The exact text, as in the two fields below."""
    customer: str = ""
    product: str = ""
    """The id of a product in one of its lines."""
    updated_since_s: float | None = None
    """Changed at this moment or later."""
    due_before_s: float | None = None
    """Due before this; orders without a due time do not match."""
    created_since_s: float | None = None
    created_before_s: float | None = None
    late_at_s: float | None = None
    """Late at this moment: due and not delivered, or delivered after the due time."""
    words: tuple[Sought, ...] = ()
    """Words that must all occur in its id, reference, customer, or products."""

    def conditions(self) -> Iterator[ColumnElement[bool]]:
        """The conditions for a row of `orders`."""
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
        if self.created_since_s is not None:
            yield orders.c.created_at_s >= self.created_since_s
        if self.created_before_s is not None:
            yield orders.c.created_at_s < self.created_before_s
        if self.late_at_s is not None:
            yield orders.c.status != OrderStatus.CANCELLED
            yield orders.c.due_at_s < func.coalesce(orders.c.delivered_at_s, self.late_at_s)
        for word in self.words:
            yield or_(holds(word.text), *(holds(f"|{product}|") for product in word.named))


EVERY_ORDER = OrderFilter()


def holds(text: str) -> ColumnElement[bool]:
    """The condition that an order contains this text, ignoring case."""
    return orders.c.search.contains(text.casefold(), autoescape=True)
