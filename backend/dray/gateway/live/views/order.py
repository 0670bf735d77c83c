"""An order as panels see it."""

from __future__ import annotations

from typing import Literal

from dray.gateway.live.views.base import View
from dray.gateway.live.views.cause import CauseView


class OrderItemView(View, kw_only=True):
    """A line of an order and how far it has come."""

    product: str
    quantity: int
    made: int = 0
    delivered: int = 0
    wanted: int | None = None
    """Less that a change asks for, while machines say what they keep."""


class OrderView(View, kw_only=True):
    """An order and how far it has come."""

    id: str
    customer: str
    reference: str | None = None
    status: Literal["stored", "released", "in_production", "in_delivery", "delivered", "cancelled"]
    items: tuple[OrderItemView, ...]
    created_at_s: float
    due_at_s: float | None = None
    priority: Literal["low", "normal", "high", "urgent"] = "normal"
    wanted_at_s: float | None = None
    """By when agents want it, as its priority makes of its due time: the first wanted is made first. None before its first release."""
    changing: bool = False
    """A change is under way: the factory has not confirmed it yet."""
    delivered_at_s: float | None = None
    releases: int = 0
    """How often it was released."""
    revoked_at_s: float | None = None
    """When its last release was taken back. Until `status` is `stored` the factory has not confirmed that."""
    waits: CauseView | None = None
    """Why it waits: nobody who lives can make what is missing, a machine of it is cut off, or material is lacking; None when it goes on."""
