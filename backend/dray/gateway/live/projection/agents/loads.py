"""Loads that wait for a person's confirmation, as panels see them."""

from __future__ import annotations

from msgspec import UNSET, UnsetType

from dray.gateway.live.views import LoadView
from dray.messages import PeopleAsBody


def loads_of(people: PeopleAsBody | UnsetType) -> tuple[LoadView, ...] | None:
    """The unconfirmed loads of an agent, oldest first; None where its body is not people."""
    if people is UNSET:
        return None
    return tuple(
        LoadView(vehicle=load.vehicle, item=load.item, quantity=load.quantity, goes=load.goes)
        for load in people.loads
    )
