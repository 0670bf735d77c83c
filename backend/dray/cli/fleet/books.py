"""The books of a fleet: what its database says of orders, and of what agents have told."""

from __future__ import annotations

import time
from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager
from typing import Self

import msgspec

from dray.cli.fleet.history import KINDS, History, Told
from dray.messages import AnyFact
from dray.store import Database, Store
from dray.store.events import EventRow

FACTS = 200_000
"""Read at once: those of KINDS that a plant of 300 agents tells in some hours; some 100 MB."""

_fact: msgspec.json.Decoder[AnyFact] = msgspec.json.Decoder(AnyFact)


class OrderCount(msgspec.Struct, frozen=True):
    """Customers' orders over some time."""

    delivered: int
    late: int
    """Delivered after their due time, or still open at the end though it has passed."""

    def since(self, before: OrderCount) -> OrderCount:
        """What has come to what there was before."""
        return OrderCount(self.delivered - before.delivered, self.late - before.late)


class Books:
    """Reads only.

    Args:
        store: the fleet's database.
    """

    def __init__(self, store: Store) -> None:
        self._store = store

    @classmethod
    @asynccontextmanager
    async def open(cls, url: str) -> AsyncIterator[Self]:
        """Open the database, and leave its tables as they are: to renew them is for the fleet's own gateway.

        Raises:
            UnavailableError: it cannot be opened.
        """
        store = Store(await Database.open(url))
        try:
            yield cls(store)
        finally:
            await store.close()

    async def orders(self) -> OrderCount:
        """All orders so far.

        Raises:
            UnavailableError: the database is away.
        """
        async with self._store.read() as work:
            totals, still_open = await work.orders.totals(), await work.orders.open()
        now_s = time.time()
        overdue = sum(order.due_at_s is not None and order.due_at_s < now_s for order in still_open)
        return OrderCount(totals.delivered, totals.delivered - totals.on_time + overdue)

    async def missing(self, numbers: Mapping[str, tuple[int, int]]) -> int:
        """How many facts are not written down yet, or are gone.

        Args:
            numbers: the life and the number of the newest fact that each agent has told.

        Raises:
            UnavailableError: the database is away.
        """
        async with self._store.read() as work:
            known = await work.events.known()
        newest = {each.agent: each for each in known}
        behind = 0
        for agent, (life, number) in numbers.items():
            last = newest.get(agent)
            same_life = last is not None and last.incarnation == life
            behind += max(0, number - (last.last if last is not None and same_life else 0))
        return behind + sum(len(each.missing) for each in known)

    async def history(self, since_s: float) -> History:
        """What has happened since then (plant clock).

        Raises:
            UnavailableError: the database is away.
        """
        async with self._store.read() as work:
            rows = await work.events.since(KINDS, since_s, FACTS)
        return History(_told(row) for row in rows)


def _told(row: EventRow) -> Told:
    return Told(row.agent, row.plant_s, _fact.decode(row.fact))
