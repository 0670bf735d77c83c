"""The customer's view of an order: no login, no names, no vehicles."""

from __future__ import annotations

from typing import Annotated

import msgspec
from fastapi import APIRouter, Path

from dray.gateway.answers import Json, described, problems
from dray.gateway.parts import Gateway
from dray.gateway.problems import not_found
from dray.gateway.routes.orders import iso
from dray.gateway.views import OrderItemView
from dray.store.orders import Order
from dray.store.progress import OrderStatus

router = APIRouter(tags=["orders"])

STAGES = (
    OrderStatus.STORED,
    OrderStatus.RELEASED,
    OrderStatus.IN_PRODUCTION,
    OrderStatus.IN_DELIVERY,
    OrderStatus.DELIVERED,
)
"""The way of an order, in order."""


class Stage(msgspec.Struct, frozen=True):
    """A step of the way."""

    status: str
    reached: bool


class TrackAnswer(msgspec.Struct, frozen=True):
    """What a customer sees."""

    status: str
    reference: str | None
    items: tuple[OrderItemView, ...]
    stages: tuple[Stage, ...]
    created_at: str
    due_at: str | None
    delivered_at: str | None


@router.get(
    "/track/{token}",
    responses={
        200: described(TrackAnswer, "The customer's view"),
        **problems(p404="There is no such page"),
    },
    response_class=Json,
)
async def track_order(gateway: Gateway, token: Annotated[str, Path(max_length=64)]) -> Json:
    """An order, for whoever knows its token."""
    async with gateway.store.read() as work:
        order = await work.orders.by_token(token)
    if order is None:
        raise not_found("tracking-page", token, "the message that brought the link")
    # Whoever has the link may see the page; search engines and shared caches may not keep it.
    headers = {"X-Robots-Tag": "noindex", "Cache-Control": "no-store"}
    return Json(_answer(order), headers=headers)


def _answer(order: Order) -> TrackAnswer:
    reached = -1 if order.status is OrderStatus.CANCELLED else STAGES.index(order.status)
    return TrackAnswer(
        status=order.status.value,
        reference=order.reference,
        items=tuple(
            OrderItemView(product=i.product, quantity=i.quantity, made=i.made, delivered=i.delivered)
            for i in order.items
        ),
        stages=tuple(Stage(stage.value, index <= reached) for index, stage in enumerate(STAGES)),
        created_at=iso(order.created_at_s),
        due_at=None if order.due_at_s is None else iso(order.due_at_s),
        delivered_at=None if order.delivered_at_s is None else iso(order.delivered_at_s),
    )
