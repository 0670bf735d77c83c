"""Loads and goods that wait for a person's confirmation."""

from __future__ import annotations

from dray.gateway.live.views.base import View


class LoadView(View, kw_only=True):
    """A load that a vehicle reports as brought or taken, and that nobody has confirmed yet."""

    vehicle: str
    item: str
    quantity: int
    goes: bool = False
    """Whether it was taken away, not brought."""


class DoubtView(View, kw_only=True):
    """A load that may lie at a place although it is not in its stock: a person counts, and says whether it does."""

    load: str
    """Its name, for that answer."""
    vehicle: str
    item: str
    name: str
    """Name of the material or product."""
    quantity: int
    brought: bool = False
    """Whether the vehicle was to bring it; otherwise to take it."""


class ToComeView(View, kw_only=True):
    """Pieces of a goal that the delivery gate admits, and whose arrival nobody has confirmed."""

    goal: str
    """Id as on the labels of the containers."""
    product: str
    """Empty if unknown."""
    quantity: int
