"""Reconciliation: reads from SQL which orders are open, and lets the outbox ask the strategist for each.

At the start, since nobody wrote down what an earlier life was answered. And again from time to time, since the
facts that should end an order may be lost with whoever kept them: the strategist's answer ends it then
(`dray.gateway.orders.completions`). Several gateways may ask for the same orders; each gets the same answers.
"""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable

from dray.errors import UnavailableError
from dray.gateway.orders.outbox import Outbox
from dray.store import Store

RECONCILE_EVERY_S = 600.0
"""Wall seconds between two times: an order that has ended unheard looks open for no longer. Each costs two
small messages per open order."""

CANCELLED_AGAIN_S = 86_400.0
"""At the start, orders that were cancelled in this time before are cancelled again: nobody wrote down whether
the strategist has heard of it, and it is seldom away for a day."""

_log = logging.getLogger(__name__)


class Reconciliation:
    """Asks the strategist for the orders that SQL believes to be open.

    Args:
        store: what is believed of them.
        outbox: asks for them.
        wall_s: the wall clock.
    """

    def __init__(self, store: Store, outbox: Outbox, wall_s: Callable[[], float]) -> None:
        self._store, self._outbox, self._wall_s = store, outbox, wall_s

    async def start(self) -> None:
        """Ask for all open orders, and drop those that were cancelled lately.

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
        """Ask for all open orders that are not asked for already; without a database not this time."""
        try:
            async with self._store.read() as work:
                still_open = await work.orders.open()
        except UnavailableError as error:
            _log.info("open orders are not reconciled this time: %s", error)
        else:
            self._outbox.ask(still_open)

    async def run(self) -> None:
        """Reconcile from time to time, until cancelled."""
        while True:
            await asyncio.sleep(RECONCILE_EVERY_S)
            await self.reconcile()
