"""Order placement: an order is taken once, however often it is sent.

The order, its idempotency key and its line of the audit log are written in one transaction, which requests that come
together share (`dray.store.orders.placing`). The answer follows the commit: an order that was answered is on disk, and one
that was not can be sent again under its key.
"""

from __future__ import annotations

import asyncio
import hashlib
from collections import Counter
from collections.abc import Callable, Collection, Iterator, Sequence
from contextlib import contextmanager, nullcontext
from http import HTTPStatus

from dray.gateway.access.audit_log import Note
from dray.gateway.http.problems import FieldError, Problem, unusable
from dray.gateway.http.shares import share_of, share_used
from dray.gateway.live.projection import Projection
from dray.gateway.orders.drafts import OrderDraft, WorkDraft, nonsense
from dray.gateway.orders.feasibility import OrderPreview, Situation, Wanted, preview
from dray.gateway.orders.idempotency import AtWork, alone, refuse_other_body
from dray.gateway.orders.order_ids import new_order_id, new_token
from dray.gateway.orders.outbox import Outbox
from dray.gateway.tracking.eta import History
from dray.gateway.tracking.facts import SILENCE_S
from dray.priorities import order_wanted_s
from dray.store import Store
from dray.store.orders.idempotency_keys import KeptAnswer
from dray.store.orders.orders import Item, Order, Referred
from dray.store.orders.placing import Placement, Placing, Wish
from dray.store.orders.progress import OrderStatus
from dray.store.orders.tracking_links import Link
from dray.store.work import Work

MAX_OPEN_ORDERS = 10_000
"""Orders that have not ended: months of work. They are kept in memory and sent to every new panel."""

SHARES = 2
"""One caller may have half of them: one system places nearly all orders of many plants."""

BATCH = 100
"""Orders of a file that are made known at once: some milliseconds of the event loop."""

LATELY_S = 3600.0
"""An order that comes with the reference and customer of one that is younger has probably been sent twice."""


class OrderPlacement:
    """Takes orders.

    Args:
        store: what is known of promises that were kept.
        placing: writes orders.
        projection: shows them; knows the plant, and what is under way.
        outbox: brings them to the strategist.
        wall_s: the wall clock.

    Attributes:
        keys_at_work: Idempotency keys of requests that are being answered at this moment.
    """

    def __init__(
        self,
        store: Store,
        placing: Placing,
        projection: Projection,
        outbox: Outbox,
        wall_s: Callable[[], float],
    ) -> None:
        self._store, self._placing = store, placing
        self._projection, self._outbox, self._wall_s = projection, outbox, wall_s
        self.keys_at_work: AtWork = {}
        self._coming: Counter[str] = Counter()
        """How many are being written at this moment, by who has placed them."""

    @property
    def open(self) -> int:
        """How many orders have not ended."""
        return self._projection.orders.open

    @property
    def now_s(self) -> float:
        """The wall clock, by which due times are judged."""
        return self._wall_s()

    @property
    def products(self) -> frozenset[str]:
        """Ids of what can be ordered at this moment."""
        return frozenset(self._projection.site.products)

    async def preview(self, draft: WorkDraft) -> OrderPreview:
        """What it would need if it were published now; nothing is kept.

        Raises:
            Problem: what it names does not exist or is past.
        """
        now_s = self._wall_s()
        self._refuse_nonsense(draft, now_s)
        projection = self._projection
        async with self._store.read() as work:
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
        return preview(projection.site.plant.file, wanted, due_at_s, situation)

    async def place(self, draft: OrderDraft, caller: str = "") -> Order:
        """Take an order that nobody asks for twice.

        Args:
            draft: a body that has the right shape.
            caller: kind and id of who asks; empty for nobody whose share is counted.

        Raises:
            Problem: what the order names does not exist or is past, or too many are open.
        """
        wish = Wish(prepare=lambda: self._prepared([draft], lambda _orders: b"", caller))
        orders, _ = await self._placed(wish, 1, caller)
        return orders[0]

    def check(self, draft: OrderDraft) -> None:
        """Refuse a draft that could not be an order now, however many are open.

        Raises:
            Problem: names the fields.
        """
        self._refuse_nonsense(draft, self._wall_s())

    @contextmanager
    def order(self, draft: OrderDraft, caller: str) -> Iterator[Order]:
        """What a draft of somebody comes to now, for who keeps it in a transaction of its own; not kept yet.

        It counts to its caller's share as long as the context lasts: until it is published, or has failed.

        Raises:
            Problem: as `place`.
        """
        with self._counted(caller, 1):
            yield self._prepared([draft], lambda _orders: b"", caller).orders[0]

    async def keep(self, work: Work, order: Order, key: str) -> None:
        """Take an order in a transaction, under a key that nobody else has; `publish` is for after it."""
        await work.orders.add(order)
        await work.links.add(order.token, Link(order.id, order.created_at_s))
        await work.keys.add(KeptAnswer(key, "", order.id, "", order.created_at_s))

    def publish(self, order: Order) -> None:
        """Let panels and the strategist know of an order that is on disk."""
        self._projection.orders.put(order)
        if order.status is OrderStatus.RELEASED:
            self._outbox.release(order)

    async def place_once(
        self,
        draft: OrderDraft,
        caller: str,
        key: str | None,
        render: Callable[[Order], bytes],
        note: Note | None = None,
    ) -> tuple[KeptAnswer, bool]:
        """Take an order, or find what was answered when it was sent before.

        Args:
            draft: a body that has the right shape.
            caller: kind and id of who asks.
            key: the Idempotency-Key; None for none.
            render: writes the answer.
            note: of the request, whose line of the audit log is written together with the order.

        Returns:
            The answer, and whether it is that of an earlier request.

        Raises:
            Problem: as `place`; or the key was used for another body, or is at work.
        """
        return await self.place_all_once([draft], caller, key, lambda orders: render(orders[0]), note)

    async def place_all_once(
        self,
        drafts: Sequence[OrderDraft],
        caller: str,
        key: str | None,
        render: Callable[[Sequence[Order]], bytes],
        note: Note | None = None,
    ) -> tuple[KeptAnswer, bool]:
        """Take some orders, all or none, as `place_once` takes one.

        Args:
            drafts: at least one.
            caller: kind and id of who asks.
            key: the Idempotency-Key; None for none.
            render: writes the answer.
            note: of the request.
        """
        fingerprint = _fingerprint(drafts)
        wish = Wish(
            key=key or "",
            fingerprint=fingerprint,
            prepare=lambda: self._prepared(drafts, render, caller),
            line=None if note is None else note.line,
        )
        async with alone(self.keys_at_work, key) if key else nullcontext():
            orders, kept = await self._placed(wish, len(drafts), caller)
        refuse_other_body(kept, fingerprint)
        if note is not None:
            note.target, note.written = kept.order_id, True
        return kept, not orders

    async def answered(self, drafts: Sequence[OrderDraft], key: str, note: Note) -> KeptAnswer | None:
        """What was answered when these drafts were sent under a key before; None if they were not.

        What has become of the plant and of due times since then is no matter of an answer that was given.

        Raises:
            Problem: the key was used for another body.
        """
        async with self._store.read() as work:
            kept = await work.keys.get(key)
        if kept is not None:
            refuse_other_body(kept, _fingerprint(drafts))
            note.target = kept.order_id
        return kept

    async def placed_lately(self, references: Collection[str]) -> list[Referred]:
        """Orders under some references that are no older than `LATELY_S` and not cancelled; of one reference oldest first."""
        async with self._store.read() as work:
            return await work.orders.referred_to(references, self._wall_s() - LATELY_S)

    async def newest_references(self, customer: str, count: int) -> list[str]:
        """The references of a customer's newest orders that nobody is known to have placed, newest first."""
        async with self._store.read() as work:
            return await work.orders.newest_references(customer, "", count)

    async def look_twice(self, draft: OrderDraft) -> tuple[FieldError, ...]:
        """A hint where another order of the last hour has the customer and reference of this one; the newest is named."""
        if draft.reference is None:
            return ()
        lately = await self.placed_lately([draft.reference])
        known = next((order for order in reversed(lately) if order.customer == draft.customer), None)
        return (
            ()
            if known is None
            else (FieldError.of("reference", "placed_twice", **known.values(self._wall_s())),)
        )

    async def _placed(self, wish: Wish, count: int, caller: str) -> tuple[Sequence[Order], KeptAnswer]:
        """Have so many orders written, and let panels and the strategist know."""
        with self._counted(caller, count):
            orders, kept = await self._placing.place(wish)
            for at, order in enumerate(orders, 1):
                self._projection.orders.put(order)
                if at % BATCH == 0:
                    await asyncio.sleep(0)
        for at, order in enumerate(orders, 1):
            if order.status is OrderStatus.RELEASED:
                self._outbox.release(order)
            if at % BATCH == 0:
                await asyncio.sleep(0)
        return orders, kept

    @contextmanager
    def _counted(self, caller: str, count: int) -> Iterator[None]:
        """So many orders of somebody are being written."""
        self._coming[caller] += count
        try:
            yield
        finally:
            self._coming[caller] -= count
            if not self._coming[caller]:
                del self._coming[caller]

    def _prepared(
        self, drafts: Sequence[OrderDraft], render: Callable[[Sequence[Order]], bytes], caller: str
    ) -> Placement:
        """The orders of some drafts, as of now.

        Raises:
            Problem: as `place`.
        """
        now_s = self._wall_s()
        for draft in drafts:
            self._refuse_nonsense(draft, now_s)
        if caller and self._projection.orders.open_of(caller) + self._coming[caller] > share_of(
            MAX_OPEN_ORDERS, SHARES
        ):
            raise share_used(
                "open orders", MAX_OPEN_ORDERS, "cancel some, or wait until some have ended", parts=SHARES
            )
        if self.open + self._coming.total() > MAX_OPEN_ORDERS:
            raise Problem(
                HTTPStatus.SERVICE_UNAVAILABLE,
                "too-many-orders",
                "Too many orders are open",
                f"{MAX_OPEN_ORDERS} orders have not ended; cancel some, or try again later",
                headers={"Retry-After": "600"},
            )
        # A millisecond apart: their ids differ by that, and they are listed in this order.
        orders = [
            _order(draft, caller, now_s + index / 1000, self._projection.speed)
            for index, draft in enumerate(drafts)
        ]
        return Placement(orders, render(orders).decode())

    def _refuse_nonsense(self, draft: WorkDraft, now_s: float) -> None:
        """Refuse what has the right shape and still means nothing here.

        Raises:
            Problem: names every field.
        """
        errors = nonsense(draft, self._projection.site.products, now_s)
        if errors:
            raise unusable(*errors)


def _fingerprint(drafts: Sequence[OrderDraft]) -> str:
    """Tells requests apart, however they are written."""
    return hashlib.sha256("\n".join(draft.model_dump_json() for draft in drafts).encode()).hexdigest()


def _order(draft: OrderDraft, caller: str, now_s: float, speed: float) -> Order:
    due_at_s = None if draft.due_at is None else draft.due_at.timestamp()
    return Order(
        id=new_order_id(now_s),
        status=OrderStatus.RELEASED if draft.release else OrderStatus.STORED,
        customer=draft.customer,
        token=new_token(),
        items=tuple(Item(item.product, item.quantity) for item in draft.items),
        created_at_s=now_s,
        reference=draft.reference,
        due_at_s=due_at_s,
        released_at_s=now_s if draft.release else None,
        releases=int(draft.release),
        updated_at_s=now_s,
        priority=draft.priority,
        caller=caller,
        wanted_at_s=order_wanted_s(draft.priority, now_s, due_at_s, speed) if draft.release else None,
    )
