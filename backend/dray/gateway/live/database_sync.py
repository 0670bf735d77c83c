"""The database sync: reads from SQL what panels show of people's decisions, at the start and while the gateway runs.

Agents are heard by every gateway, people by the one they speak to. What they decide there about orders and
alerts is in SQL before it is answered, so the others look there. A look also mends what a gateway has missed of
an order, as soon as the order's status changes.
"""

from __future__ import annotations

import logging
from collections.abc import Awaitable, Callable, Collection

from dray.gateway.live.projection import Projection
from dray.gateway.live.projection.orders import ENDED_KEPT
from dray.store import Store
from dray.store.orders.order_filter import OrderFilter
from dray.store.orders.orders import Mark, Order
from dray.store.orders.progress import ENDED, UNENDED
from dray.store.work import Work
from dray.supervision import keep_looking

LOOK_EVERY_S = 2.0
"""Wall seconds between two looks: about as long as it takes to call over to somebody at another panel. Each
reads a few values per order that has changed lately."""

OVERLAP_S = 5.0
"""Wall seconds before the newest change that was seen, from which on a look reads: clocks of several gateways differ by
less, and what was stamped before may have been committed after it."""

WHOLE_EVERY = 300
"""Looks between two that read all orders that have not ended: ten minutes. Clocks may differ by more."""

_log = logging.getLogger(__name__)


class DatabaseSync:
    """Looks for what others have written.

    Args:
        store: where they write it.
        projection: who shows it.
        follow: told of orders that others have changed, since what is repeated about them may not hold any more.
        learn: reads what others have defined, before orders for it are looked at.
    """

    def __init__(
        self,
        store: Store,
        projection: Projection,
        follow: Callable[[Order], None],
        learn: Callable[[Work], Awaitable[None]] | None = None,
    ) -> None:
        self._store, self._projection, self._follow, self._learn_more = store, projection, follow, learn
        self._marks: dict[str, Mark] = {}
        """Of the orders that had not ended at the last look."""
        self._looks, self._newest_s = 0, 0.0

    async def restore(self) -> None:
        """Learn all orders that have not ended, and the last that have.

        Raises:
            UnavailableError: the database cannot be read.
        """
        async with self._store.read() as work:
            unended = await work.orders.page(OrderFilter(statuses=UNENDED), None, None)
            orders = unended + await work.orders.page(OrderFilter(statuses=ENDED), None, ENDED_KEPT)
            goals = await work.goals.of_orders(order.id for order in orders)
            totals = await work.orders.totals()
            self._newest_s = await work.orders.newest_change_s()
        self._marks = {order.id: order.mark for order in unended}
        # Oldest first, so that the oldest ended one leaves first.
        self._projection.orders.restore([(order, goals[order.id]) for order in reversed(orders)], totals)

    async def look(self) -> None:
        """Show what has changed since the last look; what has come and ended since then, lists alone tell.

        Raises:
            UnavailableError: the database cannot be read.
        """
        self._looks += 1
        whole = self._looks % WHOLE_EVERY == 0
        async with self._store.read() as work:
            if self._learn_more is not None:
                await self._learn_more(work)
            newest_s = await work.orders.newest_change_s()
            marks = await work.orders.marks(None if whole else min(newest_s, self._newest_s) - OVERLAP_S)
            lasting = await work.alerts.lasting()
        self._newest_s = newest_s
        self._projection.alerts.on_acknowledged(lasting)
        changed = {order for order, mark in marks.items() if self._is_news(order, mark)}
        await self._learn(changed | self._marks.keys() - marks.keys() if whole else changed)

    def _is_news(self, order: str, mark: Mark) -> bool:
        known = self._marks.get(order)
        if known is not None:
            return known != mark
        if mark[0] in ENDED:
            return False
        shown = self._projection.orders.get(order)
        if shown is None or shown.mark != mark:
            return True
        self._marks[order] = mark  # It was placed here.
        return False

    async def run(self) -> None:
        """Look from time to time, until cancelled."""
        await keep_looking(
            self.look,
            LOOK_EVERY_S,
            lambda error: _log.info("what others have decided is not seen this time: %s", error),
        )

    async def _learn(self, changed: Collection[str]) -> None:
        shown = self._projection.orders
        before = {order: shown.get(order) for order in changed}
        async with self._store.read() as work:
            orders = await work.orders.many(changed)
            goals = await work.goals.of_orders(order.id for order in orders)
        for order in orders:
            if shown.get(order.id) is not before[order.id]:
                continue  # Something was heard of it meanwhile, and this may be older: the next look takes it.
            shown.put(order, goals[order.id])
            self._follow(order)
            if order.status in ENDED:
                self._marks.pop(order.id, None)
            else:
                self._marks[order.id] = order.mark
