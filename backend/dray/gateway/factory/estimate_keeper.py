"""Stores how each order's estimate moves, with the cause of each move.

Open orders take turns, so that a look costs the same for any number: of 20 orders each gets a look every ten
seconds, of 1,000 every eight minutes. Several gateways may look; the second finds no move.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable
from itertools import islice

import msgspec

from dray.gateway.factory.estimates import Since, estimate, moved
from dray.gateway.factory.lateness import HOLDS, Hold, Span, held
from dray.gateway.live.projection import Projection
from dray.gateway.tracking.eta import Range
from dray.gateway.tracking.facts import facts_of_order
from dray.gateway.tracking.track import Facts, track
from dray.messages.fact import CarrierChanged, GoalContracted, GoalLost
from dray.store import Store
from dray.store.history.events import EventFilter
from dray.store.orders.estimates import Estimate
from dray.store.orders.progress import OPEN
from dray.store.work import Work
from dray.supervision import keep_looking

LOOK_EVERY_S = 10.0
"""Wall seconds between two looks."""

ORDERS_AT_ONCE = 20
"""Orders per look: each takes some 10 ms of reading."""

EVENTS_READ = 100
"""Maximum events of an order read as possible causes; there are some per takeover and failure."""

_KINDS = (CarrierChanged.__name__, GoalLost.__name__, GoalContracted.__name__)

_READ = msgspec.json.Decoder(CarrierChanged | GoalLost | GoalContracted)

_log = logging.getLogger(__name__)


class _Seen(msgspec.Struct, frozen=True):
    """An order at its last estimate."""

    change: int
    """Number of changes by people."""
    ahead: frozenset[str]
    """Goals of other orders queued before its own."""


class EstimateKeeper:
    """Looks at open orders.

    Args:
        store: the database with estimates and events.
        projection: the live projection.
        wall_s: the wall clock.
    """

    def __init__(self, store: Store, projection: Projection, wall_s: Callable[[], float]) -> None:
        self._store, self._projection, self._wall_s = store, projection, wall_s
        self._seen: dict[str, _Seen] = {}
        """By open order."""
        self._last = ""
        """Id of the last order looked at: the next look begins after it."""

    async def run(self) -> None:
        """Look until cancelled."""
        await keep_looking(
            self.look,
            LOOK_EVERY_S,
            lambda error: _log.warning("how estimates have moved cannot be kept this time: %s", error),
        )

    async def look(self) -> None:
        """Store the moves of the orders whose turn it is.

        Raises:
            UnavailableError: the database cannot be read or written.
        """
        still_open = self._projection.orders.open_ids()
        self._seen = {order: seen for order, seen in self._seen.items() if order in still_open}
        for order in self._next(still_open):
            await self._look_at(order)

    def _next(self, still_open: Iterable[str]) -> list[str]:
        by_id = sorted(still_open)
        later = [order for order in by_id if order > self._last]
        chosen = list(islice((*later, *(order for order in by_id if order <= self._last)), ORDERS_AT_ONCE))
        if chosen:
            self._last = chosen[-1]
        return chosen

    async def _look_at(self, name: str) -> None:
        now_s = self._wall_s()
        async with self._store.read() as work:
            order = await work.orders.get(name)
            if order is None or order.status not in OPEN:
                return
            facts = await facts_of_order(self._projection, work, order, now_s)
            before = await work.estimates.newest(name)
            now, ahead = track(facts).eta, self._ahead(facts)
            seen = self._seen.setdefault(name, _Seen(order.change, ahead))
            # If the clock stands or was set back, a later look does it.
            if not moved(before, now) or (before is not None and now_s <= before.at_s):
                return
            since = await self._since(work, facts, before, now, seen)
        async with self._store.write() as work:
            # Another gateway may have stored it meanwhile.
            if await work.estimates.newest(name) == before:
                await work.estimates.add(name, estimate(before, now, since, now_s))
        self._seen[name] = _Seen(order.change, ahead)

    def _ahead(self, facts: Facts) -> frozenset[str]:
        own = {goal.id for goal in facts.goals}
        ahead: set[str] = set()
        for name in {goal.machine for goal in facts.goals if goal.machine and goal.made < goal.quantity}:
            machine = self._projection.machines.view(name)
            queue = [goal.goal for goal in machine.goals] if machine is not None else []
            mine = [place for place, goal in enumerate(queue) if goal in own]
            ahead |= set(queue[: mine[-1]] if mine else ()) - own
        return frozenset(ahead)

    async def _since(
        self, work: Work, facts: Facts, before: Estimate | None, now: Range | None, seen: _Seen
    ) -> Since:
        """The events since the last estimate."""
        since_s = facts.order.created_at_s if before is None else before.at_s
        wanted = EventFilter(kinds=_KINDS, order=facts.order.id)
        rows = await work.events.page(wanted, None, EVENTS_READ, newest_first=True)
        told = [_READ.decode(row.fact) for row in rows if row.at_s > since_s]
        makes = {goal.id: goal.machine for goal in facts.goals}
        lost = next((fact for fact in told if isinstance(fact, GoalLost)), None)
        carrier = next((fact for fact in told if isinstance(fact, CarrierChanged)), None)
        passed = sorted(self._ahead(facts) - seen.ahead)
        return Since(
            changed=facts.order.change > seen.change,
            waits=facts.waits,
            doings={makes[goal]: doing for goal, doing in sorted(facts.doings.items()) if makes.get(goal)},
            moved=None if lost is None else (lost.machine, makes.get(lost.successor, "")),
            hold=await self._hold(work, facts, before, now),
            passed=next((name for goal in passed if (name := self._projection.orders.named(goal)[0])), ""),
            replaced=None if carrier is None else (carrier.replaced, carrier.carrier),
            held_up=facts.held_up,
        )

    async def _hold(
        self, work: Work, facts: Facts, before: Estimate | None, now: Range | None
    ) -> tuple[str, Hold] | None:
        """The machine of this order that was held up longest since the last estimate."""
        if before is None or before.to_at_s is None or now is None:
            return None
        later_s = now.to_s - before.to_at_s
        machines = {goal.machine for goal in facts.goals if goal.machine}
        spans = [Span(name, name, before.at_s, facts.now_s, later_s) for name in sorted(machines)]
        asked = [(span.agent, span.since_s, span.until_s) for span in spans]
        goals = {goal.id for goal in facts.goals}
        spells = [
            msgspec.structs.replace(spell, task="") if spell.task in goals else spell
            for spell in await work.spells.of_spans(asked, sorted(HOLDS))
        ]
        found = held(spans, spells)
        return max(found.items(), key=lambda each: (each[1].lasted_s, each[0]), default=None)
