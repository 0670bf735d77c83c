"""Changing an order: what is still possible, and what results.

Changes known to be too late are refused at once. The strategist and the machines decide in the end: a change
that they cannot follow in full becomes what they keep.
"""

from __future__ import annotations

from collections.abc import Callable
from datetime import UTC, datetime
from http import HTTPStatus
from typing import Annotated

from msgspec.structs import replace
from pydantic import BaseModel, ConfigDict, Field

from dray.gateway.http.problems import FieldError, Problem, unusable
from dray.gateway.http.request_bodies import Line
from dray.gateway.http.versions import changed_since, check_version
from dray.gateway.live.projection import Projection
from dray.gateway.orders.drafts import MAX_ITEMS, MAX_QUANTITY, DueMoment
from dray.gateway.orders.outbox import Outbox
from dray.priorities import Priority, order_wanted_s
from dray.store import Store
from dray.store.orders.order_changes import Change
from dray.store.orders.orders import Order
from dray.store.orders.progress import ENDED, OPEN
from dray.store.work import Work

STEP_S = 1.0
"""Seconds by which an order is wanted before another, if it goes before the first one."""


class OrderChangeDraft(BaseModel):
    """Changes to an order; fields left out stay as they are."""

    model_config = ConfigDict(extra="forbid")

    quantities: Annotated[
        list[Annotated[int, Field(strict=True, ge=1, le=MAX_QUANTITY)]] | None, Field(max_length=MAX_ITEMS)
    ] = None
    """Pieces per item, in order; at least those made."""
    due_at: DueMoment | None = None
    """Null for none."""
    priority: Priority | None = None
    reference: Line | None = None
    """Null for none."""
    before: Annotated[str, Field(max_length=128, pattern=r"^[^\x00]*$")] | None = None
    """Id of an order before which it is to be wanted; no queue is edited, agents get another wanted time."""


def order_version(order: Order) -> str:
    """The version of an order: it follows people's changes, not the progress.

    A change that the factory accepts in full is progress; one accepted in part gives another version.
    """
    return "-".join(map(str, (order.releases, order.change, *order.wanted)))


class OrderChanging:
    """Changes orders.

    Args:
        store: the database with the orders.
        projection: shows the orders.
        outbox: tells the strategist.
        wall_s: the wall clock.
    """

    def __init__(
        self, store: Store, projection: Projection, outbox: Outbox, wall_s: Callable[[], float]
    ) -> None:
        self._store, self._projection, self._outbox, self._wall_s = store, projection, outbox, wall_s

    async def change(self, order_id: str, draft: OrderChangeDraft, if_match: str | None) -> Order | None:
        """Change an order; an order that already matches stays as it is, even if an older version was read.

        Returns:
            The order now; None if it does not exist.

        Raises:
            Problem: 409, it is too late; 412 and 428, another version was read, or none was given; 422, the
                change is invalid.
        """
        async with self._store.write() as work:
            before = await work.orders.get(order_id)
            if before is None:
                return None
            now_s = self._wall_s()
            if before.status in OPEN:
                # The projection may know more from facts than SQL.
                before = _newer(before, self._projection.orders.get(order_id))
            self._refuse_nonsense(before, draft, now_s)
            change = await self._wanted(work, before, draft)
            if _is(before, change):
                return before
            check_version(order_version(before), if_match, changed_since("order", order_id))
            _refuse_late(before, change)
            await work.order_changes.ask(before, change, now_s)
            after = await work.orders.get(order_id)
        if after is not None:
            self._projection.orders.put(after)
            if after.being_changed:
                self._outbox.release(after)
        return after

    def _refuse_nonsense(self, order: Order, draft: OrderChangeDraft, now_s: float) -> None:
        errors = []
        if draft.quantities is not None and len(draft.quantities) != len(order.items):
            reason = f"the order has {len(order.items)} items; give a quantity for each of them"
            errors.append(FieldError("quantities", reason))
        if draft.due_at is not None and draft.due_at.timestamp() <= now_s:
            now = datetime.fromtimestamp(now_s, UTC).isoformat(timespec="seconds")
            errors.append(FieldError.of("due_at", "past", now=now))
        if "priority" in draft.model_fields_set and draft.priority is None:
            errors.append(FieldError("priority", "it is low, normal, high or urgent"))
        if draft.before is not None and draft.before == order.id:
            errors.append(FieldError("before", "an order does not stand before itself; name another one"))
        if errors:
            raise unusable(*errors)

    async def _wanted(self, work: Work, order: Order, draft: OrderChangeDraft) -> Change:
        given = draft.model_fields_set
        quantities = order.wanted
        due_at_s = order.due_at_s
        if "due_at" in given:
            due_at_s = None if draft.due_at is None else draft.due_at.timestamp()
        priority = draft.priority or order.priority
        wanted_at_s = order.wanted_at_s
        if order.released_at_s is not None and (priority, due_at_s) != (order.priority, order.due_at_s):
            wanted_at_s = order_wanted_s(priority, order.released_at_s, due_at_s, self._projection.speed)
        if draft.before is not None:
            wanted_at_s = await self._before(work, order, draft.before)
        return Change(
            quantities=quantities if draft.quantities is None else tuple(draft.quantities),
            reference=draft.reference if "reference" in given else order.reference,
            due_at_s=due_at_s,
            priority=priority,
            wanted_at_s=wanted_at_s,
        )

    async def _before(self, work: Work, order: Order, other: str) -> float:
        """The wanted time that puts an order before another one: halfway to the order ahead of that."""
        queue = sorted(
            (each.wanted_at_s, each.id)
            for each in await work.orders.open()
            if each.wanted_at_s is not None and each.id != order.id
        )
        place = next((place for place, (_, name) in enumerate(queue) if name == other), None)
        if place is None or order.status not in OPEN:
            raise unusable(FieldError.of("before", "not_in_queue"))
        wanted_at_s = queue[place][0]
        return wanted_at_s - STEP_S if place == 0 else (queue[place - 1][0] + wanted_at_s) / 2


def least(order: Order) -> tuple[int, ...]:
    """Minimum pieces still possible, per item."""
    return tuple(max(1, item.made, item.delivered) for item in order.items)


def _newer(order: Order, shown: Order | None) -> Order:
    if shown is None or len(shown.items) != len(order.items):
        return order
    pairs = zip(order.items, shown.items, strict=True)
    items = tuple(
        replace(kept, made=max(kept.made, told.made), delivered=max(kept.delivered, told.delivered))
        for kept, told in pairs
    )
    return replace(order, items=items)


def _is(order: Order, change: Change) -> bool:
    """Whether an order already matches a change, or is on its way to it."""
    now = Change(
        quantities=order.wanted,
        reference=order.reference,
        due_at_s=order.due_at_s,
        priority=order.priority,
        wanted_at_s=order.wanted_at_s,
    )
    return now == change


def _refuse_late(order: Order, change: Change) -> None:
    if order.status in ENDED:
        raise Problem(
            HTTPStatus.CONFLICT,
            "order-ended",
            "The order has ended",
            f"order {order.id} is {order.status.value}; place another one",
        )
    if order.being_revoked:
        raise Problem(
            HTTPStatus.CONFLICT,
            "being-taken-back",
            "The order is being taken back",
            f"the factory has not confirmed that it has stopped working at order {order.id}; try again when it is stored",
            headers={"Retry-After": "1"},
        )
    late = [
        FieldError.of(f"quantities[{index}]", "made_already", fewest=fewest)
        for index, (wanted, fewest) in enumerate(zip(change.quantities, least(order), strict=True))
        if wanted < fewest
    ]
    if late:
        raise Problem(
            HTTPStatus.CONFLICT,
            "too-late",
            "It is too late for a part of that",
            f"{late[0].field}: {late[0].reason}",
            errors=late,
        )
