"""The database sync: reads people's decisions from SQL, at the start and while the gateway runs.

Every gateway hears the agents, but only one hears a given person. Decisions about orders and alerts are in
SQL before they are answered, so the other gateways read them there. A look also repairs what a gateway missed
about an order, as soon as the order's status changes.
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
"""Wall seconds between two looks: about as long as calling over to another panel takes. Each look reads a few
values per order that changed lately."""

OVERLAP_S = 5.0
"""Wall seconds that a look reads back before the newest change seen. Gateway clocks differ by less, and an
earlier timestamp may be committed later."""

WHOLE_EVERY = 300
"""Looks between two that read all open orders: ten minutes. This covers larger clock differences."""

_log = logging.getLogger(__name__)


class DatabaseSync:
    """Looks for changes that other gateways have written.

    Args:
        store: the database.
        projection: shows the changes.
        follow: called with each order that another gateway changed, since repeated messages about it may be
            outdated.
        learn: reads definitions made elsewhere, before the orders that need them.
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
        """Marks of the orders that were open at the last look."""
        self._looks, self._newest_s = 0, 0.0

    async def restore(self) -> None:
        """Load all open orders and the last ended ones.

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
        """Show changes since the last look; an order that came and ended in between appears in lists only.

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
        """Look every `LOOK_EVERY_S` until cancelled."""
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
                continue  # An event changed it meanwhile, and this may be older: the next look takes it.
            shown.put(order, goals[order.id])
            self._follow(order)
            if order.status in ENDED:
                self._marks.pop(order.id, None)
            else:
                self._marks[order.id] = order.mark
