"""A load that waits for a word of people."""

from __future__ import annotations

from dray.gateway.live.views.base import View


class LoadView(View, kw_only=True):
    """A load that a vehicle has brought or taken by its own word, and that nobody has confirmed yet."""

    vehicle: str
    item: str
    quantity: int
    goes: bool = False
    """It was taken away; else it was brought."""
