"""The intake: takes an order, once, however often it is sent.

The order and its idempotency key are written in one transaction, and the answer follows the commit:
an order that was answered is on disk, and one that was not can be sent again under its key.
"""

from __future__ import annotations

import hashlib
from collections.abc import AsyncIterator, Callable, Sequence
from contextlib import asynccontextmanager
from datetime import UTC, datetime
from http import HTTPStatus
from typing import Annotated, Any

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field, WithJsonSchema

from dray.gateway.bodies import Line
from dray.gateway.orderids import new_order_id, new_token
from dray.gateway.parts import Parts
from dray.gateway.preview import OrderPreview, Situation, Wanted, preview
from dray.gateway.problems import FieldError, Problem, unusable
from dray.gateway.tracking.eta import History
from dray.gateway.tracking.facts import SILENCE_S
from dray.store.keys import KeptAnswer
from dray.store.links import Link
from dray.store.orders import Item, Order
from dray.store.progress import ENDED, OrderStatus
from dray.store.work import Work

MAX_ITEMS = 50
"""Lines of one order: more than a person reads; larger orders come as several."""

MAX_QUANTITY = 10_000
"""Pieces of one line: some weeks of the default plant; a slip of the keyboard should not block it."""

MAX_OPEN_ORDERS = 10_000
"""Orders that have not ended: months of work. They are kept in memory and sent to every new panel."""

KEYS_KEPT_S = 7 * 86_400.0
"""How long an Idempotency-Key is remembered: longer than any client tries again."""


def _written_moment(value: Any) -> datetime:
    if not isinstance(value, str):
        raise ValueError("write it as text, as 2030-05-17T14:30:00Z")  # noqa: TRY004 - pydantic wants it
    try:
        moment = datetime.fromisoformat(value)
    except ValueError:
        raise ValueError("it is no ISO 8601 time; write it as 2030-05-17T14:30:00Z") from None
    if moment.tzinfo is None:
        raise ValueError("it lacks its time zone; add Z or an offset, as 2030-05-17T14:30:00+02:00")
    return moment


def _in_utc(moment: datetime) -> datetime:
    try:
        return moment.astimezone(UTC)
    except (OverflowError, ValueError):
        raise ValueError("it is out of the calendar") from None


Moment = Annotated[
    datetime,
    BeforeValidator(_written_moment),
    AfterValidator(_in_utc),
    WithJsonSchema({"type": "string", "format": "date-time"}),
]
"""A moment with its time zone, as ISO 8601 writes it; numbers are refused, for nobody knows their unit."""


class ItemDraft(BaseModel):
    """A line of a new order."""

    model_config = ConfigDict(extra="forbid")

    product: Annotated[str, Field(min_length=1, max_length=32, pattern=r"^[A-Za-z][A-Za-z0-9_.-]*$")]
    """A product's id; `GET /api/products` lists them."""
    quantity: Annotated[int, Field(strict=True, ge=1, le=MAX_QUANTITY)]
    """Pieces."""


class WorkDraft(BaseModel):
    """What is to be made. One product may stand in several lines; they are delivered as they are written."""

    model_config = ConfigDict(extra="forbid")

    items: Annotated[list[ItemDraft], Field(min_length=1, max_length=MAX_ITEMS)]
    due_at: Moment | None = None
    """When all of it should be in the delivery warehouse, with a time zone; not in the past."""


class OrderDraft(WorkDraft):
    """A new order."""

    customer: Line
    reference: Line | None = None
    """The customer's own number."""
    release: Annotated[bool, Field(strict=True)] = True
    """False: only store it; `POST /api/orders/{id}/release` starts it."""


async def look_ahead(gateway: Parts, draft: WorkDraft) -> OrderPreview:
    """What it would need if it were published now; nothing is kept.

    Raises:
        Problem: what it names does not exist or is past.
    """
    now_s = gateway.wall_s()
    _refuse_nonsense(gateway, draft, now_s)
    projection = gateway.projection
    async with gateway.store.read() as work:
        missed_by_s = await work.milestones.promises_missed_by_s()
    situation = Situation(
        machines={view.id: view for view in projection.machines.views()},
        orders=projection.orders.views(),
        history=History(missed_by_s),
        now_s=now_s,
        heard_since_s=now_s - max(SILENCE_S[0], SILENCE_S[1] / projection.speed),
        speed=projection.speed,
    )
    due_at_s = None if draft.due_at is None else draft.due_at.timestamp()
    wanted = [Wanted(item.product, item.quantity) for item in draft.items]
    return preview(gateway.plant, wanted, due_at_s, situation)


async def place(gateway: Parts, draft: OrderDraft) -> Order:
    """Take an order.

    Args:
        gateway: where to.
        draft: a body that has the right shape.

    Raises:
        Problem: what the order names does not exist or is past, or too many are open.
    """
    async with gateway.store.write() as work:
        [order] = await _written(gateway, work, [draft])
    _announce(gateway, order)
    return order


async def place_once(
    gateway: Parts, draft: OrderDraft, key: str, render: Callable[[Order], bytes]
) -> tuple[KeptAnswer, bool]:
    """Take an order, or find what was answered when it was sent before.

    Args:
        gateway: where to.
        draft: a body that has the right shape.
        key: the Idempotency-Key.
        render: writes the answer.

    Returns:
        The answer, and whether it is that of an earlier request.

    Raises:
        Problem: as `place`; or the key was used for another body, or is at work.
    """
    return await place_all_once(gateway, [draft], key, lambda orders: render(orders[0]))


async def place_all_once(
    gateway: Parts, drafts: Sequence[OrderDraft], key: str, render: Callable[[Sequence[Order]], bytes]
) -> tuple[KeptAnswer, bool]:
    """Take some orders, all or none, as `place_once` takes one.

    Args:
        gateway: where to.
        drafts: at least one.
        key: the Idempotency-Key.
        render: writes the answer.
    """
    fingerprint = hashlib.sha256("\n".join(draft.model_dump_json() for draft in drafts).encode()).hexdigest()
    async with _alone(gateway.keys_at_work, key), gateway.store.write() as work:
        kept = await work.keys.get(key)
        if kept is not None:
            _refuse_other_body(kept, fingerprint)
            return kept, True
        orders = await _written(gateway, work, drafts)
        first = orders[0]
        answer = KeptAnswer(key, fingerprint, first.id, render(orders).decode(), first.created_at_s)
        await work.keys.forget_before(first.created_at_s - KEYS_KEPT_S)
        await work.keys.add(answer)
    for order in orders:
        _announce(gateway, order)
    return answer, False


async def release(gateway: Parts, order_id: str) -> Order | None:
    """Hand a stored order to the factory; one that is there already stays as it is.

    Returns:
        The order as it is now; None when there is none.

    Raises:
        Problem: 409, it has ended.
    """
    async with gateway.store.write() as work:
        before = await work.orders.get(order_id)
        if before is None:
            return None
        if before.status is OrderStatus.CANCELLED:
            raise _ended(before, "place it again")
        if before.being_revoked:
            raise Problem(
                HTTPStatus.CONFLICT,
                "being-taken-back",
                "The order is being taken back",
                f"the factory has not confirmed that it has stopped working at order {order_id}; "
                "look at revoked_at_s and status, and try again when it is stored",
                headers={"Retry-After": "1"},
            )
        await work.orders.release(order_id, gateway.wall_s())
        after = await work.orders.get(order_id)
    if after is not None and before.status is OrderStatus.STORED:
        gateway.projection.orders.put(after)
        gateway.desk.release(after)
    return after


async def revoke(gateway: Parts, order_id: str) -> Order | None:
    """Take the start of an order back; one that is stored, or being taken back, stays as it is.

    Returns:
        The order as it is now: stored only when the factory has confirmed; None when there is none.

    Raises:
        Problem: 409, it has ended.
    """
    async with gateway.store.write() as work:
        before = await work.orders.get(order_id)
        if before is None:
            return None
        if before.status in ENDED:
            raise _ended(before, "there is nothing left to take back")
        await work.orders.revoke(order_id, gateway.wall_s())
        after = await work.orders.get(order_id)
    if after is not None and after.being_revoked and not before.being_revoked:
        gateway.projection.orders.put(after)
        gateway.desk.revoke(after)
    return after


async def cancel(gateway: Parts, order_id: str) -> Order | None:
    """Cancel an order; one that is cancelled already stays so.

    Returns:
        The order as it is now; None when there is none.

    Raises:
        Problem: 409, it is delivered.
    """
    async with gateway.store.write() as work:
        before = await work.orders.get(order_id)
        if before is None:
            return None
        if before.status is OrderStatus.DELIVERED:
            raise _ended(before, "there is nothing left to cancel")
        await work.orders.cancel(order_id, gateway.wall_s())
        after = await work.orders.get(order_id)
    if after is not None and before.status is not OrderStatus.CANCELLED:
        gateway.projection.orders.put(after)
        gateway.desk.cancel(order_id)
    return after


def _announce(gateway: Parts, order: Order) -> None:
    """The order is on disk: let panels and the strategist know."""
    gateway.projection.orders.put(order)
    if order.status is OrderStatus.RELEASED:
        gateway.desk.release(order)


@asynccontextmanager
async def _alone(at_work: set[str], key: str) -> AsyncIterator[None]:
    """Let only one request at a time work under a key."""
    if key in at_work:
        raise _key_at_work()
    at_work.add(key)
    try:
        yield
    finally:
        at_work.discard(key)


def _key_at_work() -> Problem:
    return Problem(
        HTTPStatus.CONFLICT,
        "key-at-work",
        "A request with this Idempotency-Key is still being answered",
        "wait for its answer, or send the same request again in a second",
        headers={"Retry-After": "1"},
    )


def _refuse_other_body(kept: KeptAnswer, fingerprint: str) -> None:
    if kept.fingerprint != fingerprint:
        reason = f"it was used for another order ({kept.order_id}); take a new key for a new order"
        raise Problem(
            HTTPStatus.UNPROCESSABLE_ENTITY,
            "key-used",
            "The Idempotency-Key was used for another body",
            f"Idempotency-Key: {reason}",
            errors=(FieldError("Idempotency-Key", reason),),
        )


async def _written(gateway: Parts, work: Work, drafts: Sequence[OrderDraft]) -> list[Order]:
    now_s = gateway.wall_s()
    for draft in drafts:
        _refuse_nonsense(gateway, draft, now_s)
    if gateway.projection.orders.open + len(drafts) > MAX_OPEN_ORDERS:
        raise Problem(
            HTTPStatus.SERVICE_UNAVAILABLE,
            "too-many-orders",
            "Too many orders are open",
            f"{MAX_OPEN_ORDERS} orders have not ended; cancel some, or try again later",
            headers={"Retry-After": "600"},
        )
    # A millisecond apart: their ids differ by that, and they are listed in this order.
    orders = [_order(draft, now_s + index / 1000) for index, draft in enumerate(drafts)]
    for order in orders:
        await work.orders.add(order)
        await work.links.add(order.token, Link(order.id, order.created_at_s))
    return orders


def _order(draft: OrderDraft, now_s: float) -> Order:
    return Order(
        id=new_order_id(now_s),
        status=OrderStatus.RELEASED if draft.release else OrderStatus.STORED,
        customer=draft.customer,
        token=new_token(),
        items=tuple(Item(item.product, item.quantity) for item in draft.items),
        created_at_s=now_s,
        reference=draft.reference,
        due_at_s=None if draft.due_at is None else draft.due_at.timestamp(),
        released_at_s=now_s if draft.release else None,
        releases=int(draft.release),
    )


def _refuse_nonsense(gateway: Parts, draft: WorkDraft, now_s: float) -> None:
    """Refuse what has the right shape and still means nothing here.

    Raises:
        Problem: names every field.
    """
    errors = nonsense(gateway, draft, now_s)
    if errors:
        raise unusable(*errors)


def nonsense(gateway: Parts, draft: WorkDraft, now_s: float) -> list[FieldError]:
    """What has the right shape and still means nothing here."""
    known = {product.id for product in gateway.plant.products}
    errors = [
        FieldError(
            f"items[{index}].product",
            f"this plant does not make {item.product!r}; it makes {', '.join(sorted(known))}",
        )
        for index, item in enumerate(draft.items)
        if item.product not in known
    ]
    if draft.due_at is not None and draft.due_at.timestamp() <= now_s:
        now = datetime.fromtimestamp(now_s, UTC).isoformat(timespec="seconds")
        errors.append(FieldError("due_at", f"it is past: here it is {now}; give a later time"))
    return errors


def _ended(order: Order, what_to_do: str) -> Problem:
    return Problem(
        HTTPStatus.CONFLICT,
        "order-ended",
        "The order has ended",
        f"order {order.id} is {order.status.value}; {what_to_do}",
    )
