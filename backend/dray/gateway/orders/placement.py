"""Order placement: an order is taken once, however often it is sent.

The order, its idempotency key and its audit log line are written in one transaction, which concurrent
requests share (`dray.store.orders.placing`). The answer follows the commit: an answered order is on disk, and
an unanswered one can be sent again under its key.
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
from dray.gateway.orders.order_ids import Ids, new_token
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
"""Maximum open orders: months of work. They are kept in memory and sent to every new panel."""

SHARES = 2
"""Divisor for one caller's share: in many plants one system places nearly all orders."""

BATCH = 100
"""Orders of a file announced at once: some milliseconds of the event loop."""

LATELY_S = 3600.0
"""Seconds within which an order with the same customer and reference was probably sent twice."""


class OrderPlacement:
    """Takes orders.

    Args:
        store: the database, for the history of promises.
        placing: writes orders.
        projection: shows the orders; knows the plant and present work.
        outbox: sends them to the strategist.
        wall_s: the wall clock.

    Attributes:
        keys_at_work: Idempotency keys in use.
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
        self._ids = Ids("O")
        self._coming: Counter[str] = Counter()
        """Number of orders being written, per caller."""

    @property
    def open(self) -> int:
        """Number of open orders."""
        return self._projection.orders.open

    @property
    def now_s(self) -> float:
        """The wall clock, for checking due times."""
        return self._wall_s()

    @property
    def products(self) -> frozenset[str]:
        """Ids of the products that can be ordered now."""
        return frozenset(self._projection.site.products)

    async def preview(self, draft: WorkDraft) -> OrderPreview:
        """The needs of an order if it were published now; nothing is stored.

        Raises:
            Problem: it names an unknown product or a past due time.
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
        """Place an order without an idempotency key.

        Args:
            draft: a well-formed body.
            caller: kind and id of the caller; empty to count no share.

        Raises:
            Problem: it names an unknown product or a past due time, or too many orders are open.
        """
        wish = Wish(prepare=lambda: self._prepared([draft], lambda _orders: b"", caller))
        orders, _ = await self._placed(wish, 1, caller)
        return orders[0]

    def check(self, draft: OrderDraft) -> None:
        """Refuse a draft that is invalid now, without looking at the number of open orders.

        Raises:
            Problem: names the fields.
        """
        self._refuse_nonsense(draft, self._wall_s())

    @contextmanager
    def order(self, draft: OrderDraft, caller: str) -> Iterator[Order]:
        """The order of a draft, for a caller with its own transaction; not stored yet.

        It counts to the caller's share within the context: until it is published or has failed.

        Raises:
            Problem: as `place`.
        """
        with self._counted(caller, 1):
            yield self._prepared([draft], lambda _orders: b"", caller).orders[0]

    async def keep(self, work: Work, order: Order, key: str) -> None:
        """Store an order in a transaction, under a new key; call `publish` afterwards."""
        await work.orders.add(order)
        await work.links.add(order.token, Link(order.id, order.created_at_s))
        await work.keys.add(KeptAnswer(key, "", order.id, "", order.created_at_s))

    def publish(self, order: Order) -> None:
        """Announce an order on disk to panels and the strategist."""
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
        """Place an order, or return the earlier answer to the same request.

        Args:
            draft: a well-formed body.
            caller: kind and id of the caller.
            key: the Idempotency-Key; None for none.
            render: writes the answer.
            note: the request's audit log line, written together with the order.

        Returns:
            The answer, and whether it is an earlier one.

        Raises:
            Problem: as `place`; or the key was used for another body, or is in use.
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
        """Place several orders, all or none, like `place_once`.

        Args:
            drafts: at least one.
            caller: kind and id of the caller.
            key: the Idempotency-Key; None for none.
            render: writes the answer.
            note: the request's audit log line.
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
        """The earlier answer to these drafts under a key; None if there is none.

        Later changes of the plant, or due times passed since, do not affect an earlier answer.

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
        """Uncancelled orders with these references, no older than `LATELY_S`.

        Within a reference oldest first.
        """
        async with self._store.read() as work:
            return await work.orders.referred_to(references, self._wall_s() - LATELY_S)

    async def newest_references(self, customer: str, count: int) -> list[str]:
        """References of a customer's newest orders without a known caller, newest first."""
        async with self._store.read() as work:
            return await work.orders.newest_references(customer, "", count)

    async def look_twice(self, draft: OrderDraft) -> tuple[FieldError, ...]:
        """A hint if an order of the last hour has the same customer and reference; names the newest."""
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
        """Write orders and announce them to panels and the strategist."""
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
        """Count orders of a caller while they are being written."""
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
        """The orders of some drafts as of now.

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
        # A millisecond apart, as their ids are.
        orders = [self._order(draft, caller, now_s + index / 1000) for index, draft in enumerate(drafts)]
        return Placement(orders, render(orders).decode())

    def _order(self, draft: OrderDraft, caller: str, now_s: float) -> Order:
        due_at_s = None if draft.due_at is None else draft.due_at.timestamp()
        return Order(
            id=self._ids.next(now_s),
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
            wanted_at_s=(
                order_wanted_s(draft.priority, now_s, due_at_s, self._projection.speed)
                if draft.release
                else None
            ),
        )

    def _refuse_nonsense(self, draft: WorkDraft, now_s: float) -> None:
        """Refuse a well-formed draft that is invalid here.

        Raises:
            Problem: names every field.
        """
        errors = nonsense(draft, self._projection.site.products, now_s)
        if errors:
            raise unusable(*errors)


def _fingerprint(drafts: Sequence[OrderDraft]) -> str:
    """Identifies a request's content, independent of its notation."""
    return hashlib.sha256("\n".join(draft.model_dump_json() for draft in drafts).encode()).hexdigest()
