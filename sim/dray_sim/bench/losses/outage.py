"""An outage: the database is killed with one order just before and one just after it, and started again."""

from __future__ import annotations

import asyncio
import time
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import count, cycle

from dray.cli.fleet.folder import HISTORIAN
from dray.errors import UnavailableError
from dray.messages import OrderItem
from dray.plant import Plant
from dray.store import Store
from dray.store.history.gaps import Known
from dray_sim.bench.losses.customer import Customer
from dray_sim.bench.losses.fleet import Fleet
from dray_sim.bench.losses.watch import Watch
from dray_sim.bench.postgres import PostgresServer
from dray_sim.people.demand import DUE_AFTER_S, Order

CATCH_UP_S = 240.0
"""Longest wait for the historian: it tries again every 30 s, and asks every 60 s for events that it missed."""

LOOK_S = 0.2
"""Interval between two looks whether the historian has caught up."""


@dataclass(frozen=True, slots=True)
class Outage:
    """One loss of the database, in real seconds.

    Attributes:
        away_s: from the kill until it answered again.
        refused_s: from the kill until the order was accepted that was sent at once after it.
        before: failures of that order until then, by kind.
        behind_s: from its first answer until all was written that agents had told by then.
    """

    away_s: float
    refused_s: float
    before: Counter[str]
    behind_s: float


@dataclass(frozen=True, slots=True)
class Breaker:
    """Kills the database of a fleet.

    Attributes:
        server: it is on this one, alone.
        fleet: whose.
        watch: on the fleet.
        store: the same database, as we see it.
        customer: places the orders.
        orders: the orders to place.
        down_s: real seconds before the server is started again.
    """

    server: PostgresServer
    fleet: Fleet
    watch: Watch
    store: Store
    customer: Customer
    orders: Iterator[Order]
    down_s: float

    async def kill(self) -> Outage:
        """Kill it, start it again, and wait until every event is written.

        Raises:
            UnavailableError: it does not start, or the historian does not catch up.
        """
        # Events that were missing before do not count as caused by the outage.
        await caught_up(self.fleet, self.watch, self.store)
        # An order that is accepted in the moment before must be there afterwards.
        await self.customer.order(next(self.orders))
        began_s = time.monotonic()
        await self.server.kill()
        placing = asyncio.create_task(self.customer.order(next(self.orders)))
        try:
            await asyncio.sleep(self.down_s)
            await asyncio.to_thread(self.server.start)
            back_s = time.monotonic()
            await caught_up(self.fleet, self.watch, self.store)
            behind_s = time.monotonic() - back_s
            patience = await placing
        finally:
            placing.cancel()
        return Outage(back_s - began_s, patience.waited_s, patience.before, behind_s)


def single_pieces(plant: Plant) -> Iterator[Order]:
    """Orders of one piece, of every product in turn: they are there to be answered, and are hardly any work."""
    products = cycle(plant.products)
    for number in count(1):
        yield Order(f"S{number}", 0.0, DUE_AFTER_S[0], (OrderItem(next(products), 1),))


async def caught_up(fleet: Fleet, watch: Watch, store: Store) -> None:
    """Wait until the historian has written all that agents have told by now.

    Raises:
        UnavailableError: it takes too long.
    """
    told = dict(watch.told)
    latest_s = time.monotonic() + CATCH_UP_S
    while time.monotonic() < latest_s:
        if await _written(store, told):
            return
        await asyncio.sleep(LOOK_S)
    reason = f"has not caught up in {CATCH_UP_S:.0f} s"
    raise UnavailableError(HISTORIAN, reason, fleet.last_words(HISTORIAN))


async def _written(store: Store, told: Mapping[str, tuple[int, int]]) -> bool:
    try:
        async with store.read() as work:
            known = {(each.agent, each.incarnation): each for each in await work.events.known()}
    except UnavailableError:
        # Our own connections have ended, too.
        return False
    return all(_has(known.get((agent, life)), number) for agent, (life, number) in told.items())


def _has(known: Known | None, number: int) -> bool:
    """Whether all of a life's facts up to this number are there."""
    return known is not None and known.last >= number and not any(each <= number for each in known.missing)
