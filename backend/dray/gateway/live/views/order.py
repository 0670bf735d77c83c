"""An order as panels see it."""

from __future__ import annotations

from typing import Literal

from dray.gateway.live.views.base import View
from dray.gateway.live.views.cause import CauseView


class OrderItemView(View, kw_only=True):
    """A line of an order and its progress."""

    product: str
    quantity: int
    made: int = 0
    delivered: int = 0
    wanted: int | None = None
    """Lower quantity that a change asks for, while machines report what they keep."""


class OrderView(View, kw_only=True):
    """An order and its progress."""

    id: str
    customer: str
    reference: str | None = None
    status: Literal["stored", "released", "in_production", "in_delivery", "delivered", "cancelled"]
    begun: bool = False
    """Whether production has begun: a piece is made, or a machine has a goal of it first in its queue. Before that
    an order `in_production` is planned."""
    items: tuple[OrderItemView, ...]
    created_at_s: float
    due_at_s: float | None = None
    priority: Literal["low", "normal", "high", "urgent"] = "normal"
    wanted_at_s: float | None = None
    """When agents want it, by due time and priority: earlier ones are made first. None before its first
    release."""
    changing: bool = False
    """Whether a change is under way that the factory has not confirmed yet."""
    delivered_at_s: float | None = None
    releases: int = 0
    """Number of releases."""
    revoked_at_s: float | None = None
    """When its last release was taken back. The factory has confirmed that once `status` is `stored`."""
    waits: CauseView | None = None
    """Why it waits: no living machine can make the rest, a machine is cut off, or material is missing. None
    when it goes on."""
