"""The sort order of a list of orders, and the beginnings of its pages."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, Literal

import msgspec
from sqlalchemy import ColumnElement, Index, case, func, literal_column, tuple_
from sqlalchemy.sql.elements import Grouping

from dray.store.orders.progress import ENDED
from dray.store.tables import orders

if TYPE_CHECKING:
    from dray.store.orders.orders import Order

SortedBy = Literal["created", "work", "due", "reference", "customer"]
"""`work`: in working order, open ones by their wanted times, else by their due times; then ended ones, the last first."""

Place = tuple[float | str, str]
"""An order's place in a list: its sort key, and its id."""

_NEVER_S = 1e15
"""Later than all times."""


class Sorting(msgspec.Struct, frozen=True, gc=False):
    """A sort order; equal orders are sorted by id."""

    by: SortedBy = "created"
    descending: bool = False

    def clauses(self) -> tuple[ColumnElement[Any], ColumnElement[Any]]:
        """The ORDER BY clauses of a query."""
        key, name = _KEYS[self.by][0], orders.c.id
        return (key.desc(), name.desc()) if self.descending else (key.asc(), name.asc())

    def after(self, place: Place) -> ColumnElement[bool]:
        """The condition for orders after a place."""
        here, there = tuple_(_KEYS[self.by][0], orders.c.id), tuple_(*place)
        return here < there if self.descending else here > there

    def place(self, order: Order) -> Place:
        """An order's place."""
        return _KEYS[self.by][1](order), order.id

    @property
    def shape(self) -> type[Any]:
        """The type of a place."""
        return tuple[str, str] if self.by in {"reference", "customer"} else tuple[float, str]


NEWEST_FIRST = Sorting("created", descending=True)


def _work_s(order: Order) -> float:
    if order.status not in ENDED:
        times_s = (order.wanted_at_s, order.due_at_s, _NEVER_S)
        return next(at_s for at_s in times_s if at_s is not None)
    ended_at_s = next(
        at_s for at_s in (order.delivered_at_s, order.cancelled_at_s, order.created_at_s) if at_s is not None
    )
    return 2 * _NEVER_S - ended_at_s


def _due_s(order: Order) -> float:
    return _NEVER_S if order.due_at_s is None else order.due_at_s


_ENDED: list[ColumnElement[str]] = [literal_column(f"'{status}'") for status in ENDED]
_ENDED_AT = func.coalesce(orders.c.delivered_at_s, orders.c.cancelled_at_s, orders.c.created_at_s)
_NEVER: ColumnElement[float] = literal_column(f"{_NEVER_S:.0f}.0")
_TWICE_NEVER: ColumnElement[float] = literal_column(f"{2 * _NEVER_S:.0f}.0")
_WANTED = func.coalesce(orders.c.wanted_at_s, orders.c.due_at_s, _NEVER)
_DUE = func.coalesce(orders.c.due_at_s, _NEVER)

_KEYS: Mapping[SortedBy, tuple[ColumnElement[Any], Callable[[Order], float | str]]] = {
    "created": (orders.c.created_at_s, lambda order: order.created_at_s),
    "work": (
        case((orders.c.status.in_(_ENDED), _TWICE_NEVER - _ENDED_AT), else_=_WANTED),
        _work_s,
    ),
    "due": (_DUE, _due_s),
    "reference": (
        func.coalesce(orders.c.reference, literal_column("''")),
        lambda order: order.reference or "",
    ),
    "customer": (orders.c.customer, lambda order: order.customer),
}
"""The sort keys, in SQL and for an order object: both are the same."""

for _by in ("work", "due", "reference", "customer"):
    # A page is read from its index, without sorting all orders. So constants are literals in the keys: an index does not serve a
    # condition with bound parameters.
    Index(f"ix_orders_by_{_by}", Grouping(_KEYS[_by][0]), orders.c.id)
