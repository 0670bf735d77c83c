"""Reconciliation: reads open orders from SQL, and lets the outbox ask the strategist for each.

At the start, because answers to an earlier run were not stored. Then regularly, because facts that end an
order may be lost: the strategist's answer ends it then (`dray.gateway.orders.completions`). At once when a
strategist reports the end of an order whose pieces nobody reported. They arrived while all strategists were
away, or before this one took the order over. For all orders when a strategist reports lost memory: if the
others lost theirs too, no other agent knows the orders. Several gateways may ask for the same orders; each
gets the same answers.
"""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable
from contextlib import suppress

from dray.errors import UnavailableError
from dray.gateway.orders.outbox import Outbox
from dray.store import Store
from dray.store.orders.progress import OPEN

RECONCILE_EVERY_S = 600.0
"""Wall seconds between two reconciliations: the longest time that an unheard end stays unnoticed. Each costs
two small messages per open order."""

CANCELLED_AGAIN_S = 86_400.0
"""Seconds before the start within which cancelled orders are cancelled again: it is not stored whether the
strategist heard, and it is seldom away for a day."""

_log = logging.getLogger(__name__)


class Reconciliation:
    """Asks the strategist for the orders that are open in SQL.

    Args:
        store: the database.
        outbox: asks for them.
        wall_s: the wall clock.
    """

    def __init__(self, store: Store, outbox: Outbox, wall_s: Callable[[], float]) -> None:
        self._store, self._outbox, self._wall_s = store, outbox, wall_s
        self._doubted: set[str] = set()
        """Open orders reported as ended: bounded by the open orders."""
        self._doubts_all = False
        self._news = asyncio.Event()

    async def start(self) -> None:
        """Ask for all open orders, and repeat recent cancellations.

        Raises:
            UnavailableError: the database cannot be read.
        """
        async with self._store.read() as work:
            cancelled = await work.orders.cancelled(self._wall_s() - CANCELLED_AGAIN_S)
            still_open = await work.orders.open()
        for order in cancelled:
            self._outbox.cancel(order)
        self._outbox.ask(still_open)

    async def reconcile(self) -> None:
        """Ask for all open orders not asked for already; without a database, skip this time."""
        try:
            async with self._store.read() as work:
                still_open = await work.orders.open()
        except UnavailableError as error:
            _log.info("open orders are not reconciled this time: %s", error)
        else:
            self._outbox.ask(still_open)

    def doubt(self, order: str) -> None:
        """Ask now for an open order that was reported as ended."""
        self._doubted.add(order)
        self._news.set()

    def doubt_all(self) -> None:
        """Ask now for all open orders, since a strategist may have forgotten them."""
        self._doubts_all = True
        self._news.set()

    async def ask_doubted(self) -> None:
        """Ask for doubted orders that are open in SQL; without a database, at the next reconciliation."""
        if self._doubts_all:
            self._doubts_all = False
            await self.reconcile()
        doubted, self._doubted = self._doubted, set()
        self._news.clear()
        try:
            async with self._store.read() as work:
                orders = await work.orders.many(doubted)
        except UnavailableError as error:
            _log.info("orders that are said to have ended are asked for later: %s", error)
        else:
            self._outbox.ask(order for order in orders if order.status in OPEN)

    async def run(self) -> None:
        """Reconcile regularly until cancelled."""
        clock = asyncio.get_running_loop()
        next_s = clock.time() + RECONCILE_EVERY_S
        while True:
            with suppress(TimeoutError):
                async with asyncio.timeout_at(next_s):
                    await self._news.wait()
                    await self.ask_doubted()
            if clock.time() >= next_s:
                next_s = clock.time() + RECONCILE_EVERY_S
                await self.reconcile()
