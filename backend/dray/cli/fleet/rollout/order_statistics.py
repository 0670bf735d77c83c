"""The statistics of a fleet from its database: orders, and the agents' history."""

from __future__ import annotations

import time
from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager
from typing import Self

import msgspec

from dray.cli.fleet.rollout.history import KINDS, History, RecordedFact
from dray.messages import AnyFact
from dray.store import Database, Store
from dray.store.history.events import EventRow
from dray.store.history.gaps import Known

FACTS = 200_000
"""Maximum facts read at once: those of KINDS in some hours of a plant of 300 agents; some 100 MB."""

_fact: msgspec.json.Decoder[AnyFact] = msgspec.json.Decoder(AnyFact)


class OrderCount(msgspec.Struct, frozen=True):
    """Customers' orders over some time."""

    delivered: int
    late: int
    """Orders delivered after their due time, or open and overdue at the end."""

    def since(self, before: OrderCount) -> OrderCount:
        """The difference to an earlier count."""
        return OrderCount(self.delivered - before.delivered, self.late - before.late)


class OrderStatistics:
    """Reads the statistics; changes nothing.

    Args:
        store: the fleet's database.
    """

    def __init__(self, store: Store) -> None:
        self._store = store

    @classmethod
    @asynccontextmanager
    async def open(cls, url: str) -> AsyncIterator[Self]:
        """Open the database, without migrating its tables: that is for the fleet's own gateway.

        Raises:
            UnavailableError: opening failed.
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
        """The number of facts of the present lives that are not stored yet, or are gone.

        Args:
            numbers: by agent, its life and its last counting number.

        Raises:
            UnavailableError: the database is away.
        """
        async with self._store.read() as work:
            known = {(each.agent, each.incarnation): each for each in await work.events.known()}
        lacking = 0
        for agent, (life, number) in numbers.items():
            there = known.get((agent, life), Known(agent, life, 0))
            lacking += max(0, number - there.last) + sum(each <= number for each in there.missing)
        return lacking

    async def history(self, from_s: float, to_s: float) -> History:
        """The history from one moment to another (plant clock).

        Raises:
            UnavailableError: the database is away.
        """
        async with self._store.read() as work:
            rows = await work.events.since(KINDS, from_s, FACTS)
        return History(_told(row) for row in rows if row.plant_s <= to_s)


def _told(row: EventRow) -> RecordedFact:
    return RecordedFact(row.agent, row.plant_s, _fact.decode(row.fact))
