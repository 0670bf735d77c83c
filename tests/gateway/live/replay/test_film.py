"""Recordings of earlier versions are shown as those versions showed them."""

from __future__ import annotations

from typing import Any

import msgspec

from dray.gateway.live.replay.film import Picture
from dray.gateway.live.views import OrderItemView, OrderView


def recorded(*, begun: bool | None) -> dict[str, Any]:
    """An order as a recording has it; None for a version that did not tell whether it was begun."""
    order = OrderView(
        id="O-1",
        customer="Hall 3",
        status="in_production",
        items=(OrderItemView(product="pump", quantity=5, made=0, delivered=0),),
        created_at_s=1.0,
        begun=begun is True,
    )
    told: dict[str, Any] = msgspec.to_builtins(order)
    if begun is None:
        del told["begun"]
    return told


def picture(order: dict[str, Any]) -> Picture:
    first = {"plant": "hall", "factory": None, "at_s": 1.0, "whole": True, "orders": [order]}
    site: Any = None
    return Picture(first, site)


def test_an_order_of_a_recording_that_does_not_know_of_planned_ones_is_in_production() -> None:
    assert picture(recorded(begun=None)).orders.view("O-1").begun


def test_an_order_that_was_planned_then_is_planned_in_the_film_and_begins_with_its_frame() -> None:
    shown = picture(recorded(begun=False))
    assert not shown.orders.view("O-1").begun
    shown.play({"at_s": 2.0, "orders": [{"id": "O-1", "begun": True}]})
    assert shown.orders.view("O-1").begun
