"""Changing a placed order."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Depends, Header

from dray.gateway.access.audit_log import Noted
from dray.gateway.http.problems import not_found
from dray.gateway.http.provided import Provided
from dray.gateway.http.public_urls import BaseUrl
from dray.gateway.http.request_bodies import json_only
from dray.gateway.http.responses import Json, described, problems
from dray.gateway.http.versions import version_tag
from dray.gateway.live.projection import Projection
from dray.gateway.orders.changes import OrderChangeDraft, OrderChanging, order_version
from dray.gateway.routes.orders.orders import EXAMPLE, OrderAnswer, order_answer

router = APIRouter(tags=["orders"])

IfMatch = Annotated[
    str | None, Header(alias="If-Match", description="The `ETag` of the order as it was read, or *")
]

CHANGES = {
    "sooner": {"summary": "More urgent", "value": {"priority": "urgent"}},
    "less": {"summary": "Less of its only item", "value": {"quantities": [26]}},
}


@router.patch(
    "/orders/{order}",
    dependencies=[Depends(json_only)],
    responses={
        200: described(OrderAnswer, "The order; `changing` until the factory has confirmed", EXAMPLE),
        **problems(
            p404="There is no such order",
            p409="It is too late: it has ended, is being taken back, or more is made; the answer says what is still possible",
            p412="Somebody has changed it since",
            p428="It is not said which state of it is changed",
        ),
    },
    openapi_extra={"requestBody": {"content": {"application/json": {"examples": CHANGES}}}},
    response_class=Json,
)
async def change_order(
    changing: Provided[OrderChanging],
    projection: Provided[Projection],
    base: BaseUrl,
    note: Noted,
    order: str,
    draft: OrderChangeDraft,
    if_match: IfMatch = None,
) -> Json:
    """Change an order's quantities, due time, priority, reference or place in the queue.

    Doing it twice is harmless.

    A machine keeps what it has begun, so a quantity may end up higher than requested; `changing` is true
    until that is known.
    """
    note.target = order
    note.detail["change"] = draft.model_dump_json(exclude_unset=True)
    after = await changing.change(order, draft, if_match)
    if after is None:
        raise not_found("order", order, "GET /api/orders")
    orders = projection.orders
    answer = order_answer(after, base, orders.why_waits(after.id), begun=orders.begun(after.id))
    return Json(answer, headers={"ETag": version_tag(order_version(after))})
