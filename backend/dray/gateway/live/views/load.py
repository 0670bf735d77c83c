"""Loads and goods that wait for a word of people."""

from __future__ import annotations

from dray.gateway.live.views.base import View


class LoadView(View, kw_only=True):
    """A load that a vehicle has brought or taken by its own word, and that nobody has confirmed yet."""

    vehicle: str
    item: str
    quantity: int
    goes: bool = False
    """It was taken away; else it was brought."""


class ToComeView(View, kw_only=True):
    """Pieces of a goal that the delivery gate lets in, and of which people have not said that they have arrived."""

    goal: str
    """As it stands on the labels of the containers."""
    product: str
    """Empty where that is not known."""
    quantity: int
