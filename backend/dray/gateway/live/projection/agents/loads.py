"""Loads that wait for a person's confirmation or count, as panels see them."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from msgspec import UNSET, UnsetType

from dray.gateway.live.views import DoubtView, LoadView
from dray.messages import DoubtfulLoad, PeopleAsBody


def loads_of(people: PeopleAsBody | UnsetType) -> tuple[LoadView, ...] | None:
    """The unconfirmed loads of an agent, oldest first; None where its body is not people."""
    if people is UNSET:
        return None
    return tuple(
        LoadView(vehicle=load.vehicle, item=load.item, quantity=load.quantity, goes=load.goes)
        for load in people.loads
    )


def doubts_of(doubts: Iterable[DoubtfulLoad], name_of: Callable[[str], str]) -> tuple[DoubtView, ...]:
    """The doubtful loads of an agent, oldest first.

    Args:
        doubts: those of its heartbeat.
        name_of: the name of a material or product.
    """
    return tuple(
        DoubtView(
            load=each.load,
            vehicle=each.vehicle,
            item=each.item,
            name=name_of(each.item),
            quantity=each.quantity,
            brought=each.brought,
        )
        for each in doubts
    )
