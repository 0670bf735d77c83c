"""The intake: takes an order, once, however often it is sent.

The order and its idempotency key are written in one transaction, and the answer follows the commit:
an order that was answered is on disk, and one that was not can be sent again under its key.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from http import HTTPStatus

from dray.gateway.drafts import OrderDraft, WorkDraft, nonsense
from dray.gateway.idempotency import KEYS_KEPT_S, alone, refuse_other_body
from dray.gateway.orderids import new_order_id, new_token
from dray.gateway.parts import Parts
from dray.gateway.preview import OrderPreview, Situation, Wanted, preview
from dray.gateway.problems import Problem, unusable
from dray.gateway.tracking.eta import History
from dray.gateway.tracking.facts import SILENCE_S
from dray.store.keys import KeptAnswer
from dray.store.links import Link
from dray.store.orders import Item, Order
from dray.store.progress import OrderStatus
from dray.store.work import Work

MAX_OPEN_ORDERS = 10_000
"""Orders that have not ended: months of work. They are kept in memory and sent to every new panel."""


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
    async with alone(gateway.keys_at_work, key), gateway.store.write() as work:
        kept = await work.keys.get(key)
        if kept is not None:
            refuse_other_body(kept, fingerprint)
            return kept, True
        orders = await _written(gateway, work, drafts)
        first = orders[0]
        answer = KeptAnswer(key, fingerprint, first.id, render(orders).decode(), first.created_at_s)
        await work.keys.forget_before(first.created_at_s - KEYS_KEPT_S)
        await work.keys.add(answer)
    for order in orders:
        _announce(gateway, order)
    return answer, False


def _announce(gateway: Parts, order: Order) -> None:
    """The order is on disk: let panels and the strategist know."""
    gateway.projection.orders.put(order)
    if order.status is OrderStatus.RELEASED:
        gateway.desk.release(order)


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
        updated_at_s=now_s,
    )


def _refuse_nonsense(gateway: Parts, draft: WorkDraft, now_s: float) -> None:
    """Refuse what has the right shape and still means nothing here.

    Raises:
        Problem: names every field.
    """
    errors = nonsense(draft, gateway.plant, now_s)
    if errors:
        raise unusable(*errors)
