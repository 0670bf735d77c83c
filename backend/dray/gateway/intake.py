"""The intake: takes an order, once, however often it is sent.

The order, its idempotency key and its line of the audit log are written in one transaction, which requests that come
together share (`dray.store.placing`). The answer follows the commit: an order that was answered is on disk, and one
that was not can be sent again under its key.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from contextlib import nullcontext
from http import HTTPStatus

from dray.gateway.access.trail import Note
from dray.gateway.drafts import OrderDraft, WorkDraft, nonsense
from dray.gateway.idempotency import alone, refuse_other_body
from dray.gateway.orderids import new_order_id, new_token
from dray.gateway.parts import Parts
from dray.gateway.preview import OrderPreview, Situation, Wanted, preview
from dray.gateway.problems import Problem, unusable
from dray.gateway.tracking.eta import History
from dray.gateway.tracking.facts import SILENCE_S
from dray.store.keys import KeptAnswer
from dray.store.orders import Item, Order
from dray.store.placing import Placement, Wish
from dray.store.progress import OrderStatus

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
    """Take an order that nobody asks for twice.

    Args:
        gateway: where to.
        draft: a body that has the right shape.

    Raises:
        Problem: what the order names does not exist or is past, or too many are open.
    """
    wish = Wish(prepare=lambda: _prepared(gateway, [draft], lambda _orders: b""))
    orders, _ = await _placed(gateway, wish, 1)
    return orders[0]


async def place_once(
    gateway: Parts,
    draft: OrderDraft,
    key: str | None,
    render: Callable[[Order], bytes],
    note: Note | None = None,
) -> tuple[KeptAnswer, bool]:
    """Take an order, or find what was answered when it was sent before.

    Args:
        gateway: where to.
        draft: a body that has the right shape.
        key: the Idempotency-Key; None for none.
        render: writes the answer.
        note: of the request, whose line of the audit log is written together with the order.

    Returns:
        The answer, and whether it is that of an earlier request.

    Raises:
        Problem: as `place`; or the key was used for another body, or is at work.
    """
    return await place_all_once(gateway, [draft], key, lambda orders: render(orders[0]), note)


async def place_all_once(
    gateway: Parts,
    drafts: Sequence[OrderDraft],
    key: str | None,
    render: Callable[[Sequence[Order]], bytes],
    note: Note | None = None,
) -> tuple[KeptAnswer, bool]:
    """Take some orders, all or none, as `place_once` takes one.

    Args:
        gateway: where to.
        drafts: at least one.
        key: the Idempotency-Key; None for none.
        render: writes the answer.
        note: of the request.
    """
    fingerprint = hashlib.sha256("\n".join(draft.model_dump_json() for draft in drafts).encode()).hexdigest()
    wish = Wish(
        key=key or "",
        fingerprint=fingerprint,
        prepare=lambda: _prepared(gateway, drafts, render),
        line=None if note is None else note.line,
    )
    async with alone(gateway.keys_at_work, key) if key else nullcontext():
        orders, kept = await _placed(gateway, wish, len(drafts))
    refuse_other_body(kept, fingerprint)
    if note is not None:
        note.target, note.written = kept.order_id, True
    return kept, not orders


async def _placed(gateway: Parts, wish: Wish, count: int) -> tuple[Sequence[Order], KeptAnswer]:
    """Have so many orders written, and let panels and the strategist know."""
    gateway.intake.coming += count
    try:
        orders, kept = await gateway.intake.placing.place(wish)
        for order in orders:
            gateway.projection.orders.put(order)
    finally:
        gateway.intake.coming -= count
    for order in orders:
        if order.status is OrderStatus.RELEASED:
            gateway.desk.release(order)
    return orders, kept


def _prepared(
    gateway: Parts, drafts: Sequence[OrderDraft], render: Callable[[Sequence[Order]], bytes]
) -> Placement:
    """The orders of some drafts, as of now.

    Raises:
        Problem: as `place`.
    """
    now_s = gateway.wall_s()
    for draft in drafts:
        _refuse_nonsense(gateway, draft, now_s)
    if gateway.projection.orders.open + gateway.intake.coming > MAX_OPEN_ORDERS:
        raise Problem(
            HTTPStatus.SERVICE_UNAVAILABLE,
            "too-many-orders",
            "Too many orders are open",
            f"{MAX_OPEN_ORDERS} orders have not ended; cancel some, or try again later",
            headers={"Retry-After": "600"},
        )
    # A millisecond apart: their ids differ by that, and they are listed in this order.
    orders = [_order(draft, now_s + index / 1000) for index, draft in enumerate(drafts)]
    return Placement(orders, render(orders).decode())


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
