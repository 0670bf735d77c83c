"""Which orders a list is asked for."""

from __future__ import annotations

from collections.abc import Collection, Iterator

import msgspec
from sqlalchemy import ColumnElement, exists, func, or_

from dray.store.database.searching import Sought
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
    created_since_s: float | None = None
    created_before_s: float | None = None
    late_at_s: float | None = None
    """Due by then and not delivered, or delivered after it was due."""
    words: tuple[Sought, ...] = ()
    """All of them stand somewhere in its id, reference or customer, or in what it is of."""

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
    """Whether an order holds this text, in whatever case."""
    return orders.c.search.contains(text.casefold(), autoescape=True)
