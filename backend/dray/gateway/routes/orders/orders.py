"""Orders: placing, finding, releasing, taking back and cancelling them."""

from __future__ import annotations

from collections.abc import AsyncIterator, Mapping
from http import HTTPStatus
from typing import Annotated

import msgspec
from fastapi import APIRouter, Depends, Query, Request, Response

from dray.gateway.access.audit_log import note_of
from dray.gateway.access.caller import caller_of
from dray.gateway.http.csv_tables import Format, Row, table, with_csv
from dray.gateway.http.problems import FieldError, not_found
from dray.gateway.http.provided import Provided, provided
from dray.gateway.http.public_urls import BaseUrl, public_url
from dray.gateway.http.request_bodies import json_only
from dray.gateway.http.responses import (
    PAGE,
    Cursor,
    Json,
    Limit,
    counted_in_turns,
    counted_list_of,
    created_once,
    described,
    iso,
    problems,
    read_cursor,
    write_cursor,
)
from dray.gateway.http.versions import version_tag
from dray.gateway.live.projection import Projection
from dray.gateway.live.projection.orders import order_view
from dray.gateway.live.views import CauseView, OrderItemView, OrderView
from dray.gateway.orders.actions import OrderActions
from dray.gateway.orders.changes import order_version
from dray.gateway.orders.drafts import Moment, OrderDraft, WorkDraft
from dray.gateway.orders.feasibility import OrderPreview
from dray.gateway.orders.idempotency import Key, own_key
from dray.gateway.orders.item_promises import NO_PROMISE, promises_of
from dray.gateway.orders.placement import OrderPlacement
from dray.gateway.routes.search import NowS, Words
from dray.settings import Settings
from dray.store import Store
from dray.store.orders.order_filter import OrderFilter
from dray.store.orders.order_sorting import Place, SortedBy, Sorting
from dray.store.orders.orders import Order
from dray.store.orders.progress import OPEN, OrderStatus

router = APIRouter(tags=["orders"])


class OrderAnswer(OrderView, kw_only=True):
    """An order, with its times also in ISO 8601 and the address of the customer's page."""

    created_at: str
    due_at: str | None = None
    delivered_at: str | None = None
    updated_at: str
    """Time of its last change, as in `updated_since`."""
    tracking_url: str
    etag: str
    """Its `ETag`, for `If-Match` when it is changed."""


class PlacedOrder(OrderAnswer, kw_only=True):
    """A new order."""

    hints: tuple[FieldError, ...] = ()
    """Oddities: another order of the last hour has the same customer and reference. The order is placed
    anyway."""


def _placed_order(answer: OrderAnswer, hints: tuple[FieldError, ...]) -> PlacedOrder:
    return PlacedOrder(**{name: getattr(answer, name) for name in answer.__struct_fields__}, hints=hints)


EXAMPLE = OrderAnswer(
    id="O-1M9K3X2A4-K7QM",
    customer="Muster GmbH",
    reference="4711",
    status="released",
    items=(OrderItemView(product="P1", quantity=5),),
    created_at_s=1_893_456_000.0,
    due_at_s=1_893_463_200.0,
    wanted_at_s=1_893_463_200.0,
    created_at="2030-01-01T00:00:00Z",
    due_at="2030-01-01T02:00:00Z",
    updated_at="2030-01-01T00:00:00Z",
    tracking_url="http://127.0.0.1:8000/track/Vb2n-0yqk4QmJ8cA1xRZ7uTLw9sEhGdf",
    etag='"1-0-5"',
)

ROWS_AT_ONCE = 500
"""Orders per read for a table."""

Text = Annotated[str, Query(max_length=200, pattern=r"^[^\x00]*$")]
"""As long as the longest customer; without NUL, which PostgreSQL text cannot hold."""


async def _wanted(
    words: Words,
    now_s: NowS,
    status: Annotated[list[OrderStatus] | None, Query(description="Only these; may be repeated")] = None,
    reference: Annotated[Text, Query(description="The customer's own number, as it was given")] = "",
    customer: Annotated[Text, Query(description="As it was given")] = "",
    product: Annotated[Text, Query(description="The id of a product of which it has a line")] = "",
    updated_since: Annotated[
        Moment | None, Query(description="Changed then or later, in ISO 8601 with its zone")
    ] = None,
    due_before: Annotated[
        Moment | None, Query(description="Due before then; only those with a due time")
    ] = None,
    created_since: Annotated[Moment | None, Query(description="Placed then or later")] = None,
    created_before: Annotated[Moment | None, Query(description="Placed before then")] = None,
    late: Annotated[
        bool, Query(description="Only those that are due and not delivered, or were late")
    ] = False,
) -> OrderFilter:
    return OrderFilter(
        statuses=status or (),
        reference=reference,
        customer=customer,
        product=product,
        updated_since_s=None if updated_since is None else updated_since.timestamp(),
        due_before_s=None if due_before is None else due_before.timestamp(),
        created_since_s=None if created_since is None else created_since.timestamp(),
        created_before_s=None if created_before is None else created_before.timestamp(),
        late_at_s=now_s if late else None,
        words=words,
    )


Wanted = Annotated[OrderFilter, Depends(_wanted)]
"""A router's parameter: the filter of a list of orders."""

COLUMNS = (
    *("order", "customer", "reference", "status"),
    *("product", "quantity", "made", "delivered"),
    *("created_at", "due_at", "released_at", "revoked_at", "delivered_at", "cancelled_at", "priority"),
    *("promised_at", "first_promised_at", "came_before"),
)

WORK = {
    "soon": {"summary": "Five pieces", "value": {"items": [{"product": "P1", "quantity": 5}]}},
}

DRAFTS = {
    "soon": {
        "summary": "Five pieces, as soon as possible",
        "value": {"customer": "Muster GmbH", "items": [{"product": "P1", "quantity": 5}]},
    },
    "later": {
        "summary": "Stored, with a due time",
        "value": {
            "customer": "Muster GmbH",
            "items": [{"product": "P1", "quantity": 5}, {"product": "P2", "quantity": 20}],
            "due_at": "2030-01-01T02:00:00Z",
            "reference": "4711",
            "release": False,
        },
    },
}


@router.post(
    "/orders",
    status_code=HTTPStatus.CREATED,
    dependencies=[Depends(json_only)],
    responses={
        201: created_once(PlacedOrder, "The order", _placed_order(EXAMPLE, ())),
        **problems(
            p409="A request with this key is still being answered",
            p429="Too many orders of this caller are open",
            p503="Too many orders are open",
        ),
    },
    openapi_extra={"requestBody": {"content": {"application/json": {"examples": DRAFTS}}}},
    response_class=Json,
)
async def place_order(request: Request, draft: OrderDraft, key: Key = None) -> Json:
    """Place an order."""
    # Dependencies as parameters, as used elsewhere, would each cost as much as an order's JSON.
    base = public_url(provided(request.app, Settings), request)
    caller, placement = caller_of(request), provided(request.app, OrderPlacement)
    hints = await placement.look_twice(draft)

    def render(order: Order) -> bytes:
        return msgspec.json.encode(_placed_order(order_answer(order, base), hints))

    kept, replayed = await placement.place_once(
        draft, caller.key, None if key is None else own_key(caller, key), render, note_of(request)
    )
    return _created(kept.order_id, kept.answer.encode(), {"Idempotency-Replayed": "true"} if replayed else {})


@router.post(
    "/orders/preview",
    dependencies=[Depends(json_only)],
    responses={200: described(OrderPreview, "What it would need")},
    openapi_extra={"requestBody": {"content": {"application/json": {"examples": WORK}}}},
    response_class=Json,
)
async def preview_order(placement: Provided[OrderPlacement], draft: WorkDraft) -> Json:
    """The needs of an order if it were published now; nothing is stored.

    Materials against stocks and other orders' needs, capable machines and their queues, and an estimated
    delivery.
    """
    return Json(await placement.preview(draft))


@router.get(
    "/orders",
    responses={200: with_csv(counted_list_of(OrderAnswer, "Orders, newest first"))},
    response_class=Json,
)
async def list_orders(
    store: Provided[Store],
    projection: Provided[Projection],
    base: BaseUrl,
    wanted: Wanted,
    sort: Annotated[
        SortedBy, Query(description="`work`: open ones by due time, then the last that ended")
    ] = "created",
    descending: bool | None = None,
    cursor: Cursor = None,
    limit: Limit = PAGE,
    format: Format = "json",  # noqa: A002 - the word that others use
) -> Response:
    """All orders ever; as a table, with a row for each of their items.

    Newest first; any other `sort` is ascending, unless `descending` is set. Filters are combined. To follow
    changes, pass the newest `updated_at` of the last answer as `updated_since`: orders changed at that very
    moment appear again, and none is missed.
    """
    sorting = Sorting(sort, sort == "created" if descending is None else descending)
    if format == "csv":
        return table("orders", COLUMNS, _rows(store, wanted, sorting, projection.speed))
    after = read_cursor(cursor, sorting.shape)
    async with store.read() as work:
        orders = await work.orders.page(wanted, after, limit + 1, sorting)
        is_all = cursor is None and len(orders) <= limit
        total = len(orders) if is_all else None if wanted.words else await work.orders.total(wanted)
    last = orders[limit - 1] if len(orders) > limit else None
    return await counted_in_turns(
        orders[:limit],
        lambda order: order_answer(
            order, base, projection.orders.why_waits(order.id), begun=projection.orders.begun(order.id)
        ),
        None if last is None else write_cursor(*sorting.place(last)),
        total,
    )


@router.get(
    "/orders/{order}",
    responses={
        200: described(OrderAnswer, "The order", EXAMPLE),
        **problems(p404="There is no such order"),
    },
    response_class=Json,
)
async def get_order(
    store: Provided[Store], projection: Provided[Projection], base: BaseUrl, order: str
) -> Json:
    """One order."""
    async with store.read() as work:
        found = await work.orders.get(order)
    return _answer(projection, found, order, base)


@router.post(
    "/orders/{order}/release",
    responses={
        200: described(OrderAnswer, "The order, released", EXAMPLE),
        **problems(p404="There is no such order", p409="It is cancelled, or being taken back"),
    },
    response_class=Json,
)
async def release_order(
    actions: Provided[OrderActions], projection: Provided[Projection], base: BaseUrl, order: str
) -> Json:
    """Release a stored order to the factory; doing it twice is harmless."""
    return _answer(projection, await actions.release(order), order, base)


@router.post(
    "/orders/{order}/revoke",
    responses={
        200: described(OrderAnswer, "The order; stored once the factory has confirmed", EXAMPLE),
        **problems(p404="There is no such order", p409="It has ended"),
    },
    response_class=Json,
)
async def revoke_order(
    actions: Provided[OrderActions], projection: Provided[Projection], base: BaseUrl, order: str
) -> Json:
    """Take back an order's release; doing it twice is harmless.

    What has arrived stays delivered. `revoked_at_s` is set at once; once the factory has confirmed, `status`
    is `stored`, and the rest can be released again. Finished pieces that have not arrived go to the next
    order of that product.
    """
    return _answer(projection, await actions.revoke(order), order, base)


@router.post(
    "/orders/{order}/cancel",
    responses={
        200: described(OrderAnswer, "The order, cancelled", EXAMPLE),
        **problems(p404="There is no such order", p409="It is delivered"),
    },
    response_class=Json,
)
async def cancel_order(
    actions: Provided[OrderActions], projection: Provided[Projection], base: BaseUrl, order: str
) -> Json:
    """Cancel an order; doing it twice is harmless. Finished pieces stay."""
    return _answer(projection, await actions.cancel(order), order, base)


def order_answer(
    order: Order, base_url: str, waits: CauseView | None = None, *, begun: bool = False
) -> OrderAnswer:
    """An order as in REST answers.

    Args:
        order: the order.
        base_url: this gateway's address, without a slash at the end.
        waits: why it waits; None when it does not.
        begun: whether a machine works at it.
    """
    view = order_view(order, waits, begun=begun)
    fields = {name: getattr(view, name) for name in view.__struct_fields__}
    return OrderAnswer(
        **fields,
        created_at=iso(order.created_at_s),
        due_at=None if order.due_at_s is None else iso(order.due_at_s),
        delivered_at=None if order.delivered_at_s is None else iso(order.delivered_at_s),
        updated_at=iso(order.updated_at_s),
        tracking_url=f"{base_url}/track/{order.token}",
        etag=version_tag(order_version(order)),
    )


async def _rows(store: Store, wanted: OrderFilter, sorting: Sorting, speed: float) -> AsyncIterator[Row]:
    """All orders, read page by page, so that a long table blocks nobody."""
    after: Place | None = None
    while True:
        async with store.read() as work:
            orders = await work.orders.page(wanted, after, ROWS_AT_ONCE, sorting)
            goals = await work.goals.of_orders([order.id for order in orders if order.status in OPEN])
            running = [goal.id for of_order in goals.values() for goal in of_order if goal.machine]
            moved = await work.milestones.moved_promises(running)
        for order in orders:
            promises = promises_of(goals.get(order.id, ()), moved, speed)
            moments = (order.created_at_s, order.due_at_s, order.released_at_s, order.revoked_at_s)
            ends = (order.delivered_at_s, order.cancelled_at_s)
            times = [None if at_s is None else iso(at_s) for at_s in (*moments, *ends)]
            head = (order.id, order.customer, order.reference, order.status.value)
            for place, item in enumerate(order.items):
                promise = promises.get(place, NO_PROMISE)
                yield (
                    *head,
                    item.product,
                    item.quantity,
                    item.made,
                    item.delivered,
                    *times,
                    order.priority.value,
                    *(None if at_s is None else iso(at_s) for at_s in (promise.at_s, promise.first_at_s)),
                    promise.came_before or None,
                )
        if len(orders) < ROWS_AT_ONCE:
            return
        after = sorting.place(orders[-1])


def _created(order_id: str, answer: bytes, headers: Mapping[str, str] | None = None) -> Json:
    location = {"Location": f"/api/orders/{order_id}"}
    return Json(answer, HTTPStatus.CREATED, headers=location | dict(headers or {}))


def _answer(projection: Projection, order: Order | None, order_id: str, base_url: str) -> Json:
    if order is None:
        raise not_found("order", order_id, "GET /api/orders")
    orders = projection.orders
    answer = order_answer(order, base_url, orders.why_waits(order.id), begun=orders.begun(order.id))
    return Json(answer, headers={"ETag": version_tag(order_version(order))})
