"""A campaign: a factory of processes runs undisturbed, then under kills; then its remains are collected."""

from __future__ import annotations

import asyncio
import time
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from random import Random

from dray.cli.fleet.folder import GATEWAY, HISTORIAN
from dray.errors import UnavailableError
from dray.plant import Plant
from dray.store import Store, open_store
from dray.store.orders.order_filter import EVERY_ORDER
from dray.store.orders.orders import Order
from dray.store.orders.progress import OrderStatus
from dray.store.orders.transports import TransportFilter
from dray_sim.bench.losses.calling import Called, Calling
from dray_sim.bench.losses.cost import Kill
from dray_sim.bench.losses.customer import Customer
from dray_sim.bench.losses.fleet import Fleet, running
from dray_sim.bench.losses.history import History, read_database, read_journals
from dray_sim.bench.losses.judgement import Aftermath
from dray_sim.bench.losses.outage import Breaker, Outage, caught_up, single_pieces
from dray_sim.bench.losses.victims import (
    DATABASE,
    LASTING,
    OFFICES,
    STAYS_AWAY,
    Kind,
    Rota,
    Victim,
    crew,
    machine,
    vehicle,
)
from dray_sim.bench.losses.watch import Watch, gathered
from dray_sim.bench.postgres import PostgresServer
from dray_sim.people import demand
from dray_sim.remote import count_pieces

JOIN_S = 240.0
"""Longest time for two dozen processes to import and join, on a busy computer."""

RETURN_S = 240.0
"""Longest time without a kill because earlier victims are not back: as long as all need to join."""

ROWS = 100_000
"""Transports that are read at the end: all."""

LOOK_S = 1.0
"""Interval between two looks whether all orders have been delivered."""


@dataclass(frozen=True, slots=True)
class Campaign:
    """The plan of a campaign.

    Attributes:
        plant: the factory.
        speed: factory seconds per real second.
        plain: links without certificates.
        load: part of the machines' time that the demand takes.
        head_start_s: the demand begins as if it had run for so long (plant clock): busy from the first minute.
        warm_s: real seconds before anything is measured: buffers fill, and vehicles find their rhythm.
        quiet_s: real seconds without a kill: the baseline.
        each: kills of every kind in turn.
        lasting: of these, a vehicle and a machine that stay away.
        kills: of all these and of random ones together.
        pause_s: real seconds from one kill to the next, at least.
        down: processes that are away at once, at most, beside those that stay away: a busy computer starts them slowly.
        lasting_s: real seconds for which somebody stays away.
        dark_s: real seconds before a killed database is started again.
        drain_s: real seconds without one more piece delivered, after which the last orders are taken for lost.
        seed: of the demand, and of the choice of victims.
        traffic: whether vehicles drive with right of way; None: as `dray fleet up` does.
    """

    plant: Plant
    speed: float
    plain: bool
    load: float
    head_start_s: float
    warm_s: float
    quiet_s: float
    each: int
    lasting: int
    kills: int
    pause_s: float
    down: int
    lasting_s: float
    dark_s: float
    drain_s: float
    seed: int
    traffic: bool | None = None
    calls: int = 0
    """Number of plain transports that are called meanwhile."""
    recurring: int = 0
    """Number of recurring transports, each called once."""
    call_every_s: float = 2.4
    """Real seconds from one call to the next."""


@dataclass(frozen=True, slots=True)
class Outcome:
    """The results of a campaign.

    Attributes:
        campaign: the plan.
        kills: of processes, in order.
        outages: of the database, in order.
        quiet_s, killing_s: the span without kills, and that of the kills: from and to (plant clock).
        answered_s: until the slowest order was answered, in real seconds.
        after: the state at the end.
        called: the calls meanwhile; None for none.
        asked_s: by transport that was called for, when (plant clock).
    """

    campaign: Campaign
    kills: list[Kill]
    outages: list[Outage]
    quiet_s: tuple[float, float]
    killing_s: tuple[float, float]
    answered_s: float
    after: Aftermath
    called: Called | None = None
    asked_s: Mapping[str, float] = field(default_factory=dict)


async def play(campaign: Campaign, folder: Path, server: PostgresServer | None = None) -> Outcome:
    """Play it.

    Args:
        campaign: the plan.
        folder: an empty one.
        server: for the database, and killed like all else; without one it is on SQLite, in a file that nobody can kill.

    Raises:
        UnavailableError: the fleet does not start, ends midway, or does not recover from what is killed.
    """
    plant = campaign.plant
    database_url = "" if server is None else server.url()
    async with running(
        folder,
        plant,
        speed=campaign.speed,
        plain=campaign.plain,
        database_url=database_url,
        traffic=campaign.traffic,
    ) as fleet:
        store = await open_store(fleet.database_url)
        try:
            with fleet.bus() as bus:
                watch = await gathered(fleet, bus, JOIN_S)
                first = await count_pieces(bus.inner, plant.id)
                field_ = _Field(campaign, fleet, watch, store, server)
                quiet_s, killing_s = await field_.play()
                last = await count_pieces(bus.inner, plant.id)
                await caught_up(fleet, watch, store)
                kills, registry = field_.kills, fleet.registry
                heartbeats = list(watch.heard.machines.values())
        finally:
            await store.close()
    store = await open_store(fleet.database_url)
    try:
        written, journalled = await read_database(store), read_journals(fleet.journals)
        history = History()
        history.add(written)
        unwritten = history.lacking(event for event in journalled if event.at_s < killing_s[1])
        history.add(journalled)
        orders = await _all_orders(store)
        async with store.read() as work:
            rows = [] if field_.calling is None else await work.transports.page(TransportFilter(), None, ROWS)
    finally:
        await store.close()
    asked_s = {row.id: fleet.time.to_plant_s(row.created_at_s) for row in rows}
    after = Aftermath(
        history=history,
        unwritten=unwritten,
        heartbeats=heartbeats,
        accepted=field_.customer.accepted,
        refused=field_.customer.refused,
        orders=orders,
        first=first,
        last=last,
        starts={member.name: member.starts for member in registry.members},
        kills=Counter(kill.victim.name for kill in kills),
    )
    called = None if field_.calling is None else field_.calling.called
    return Outcome(
        campaign, kills, field_.outages, quiet_s, killing_s, field_.customer.waited_s, after, called, asked_s
    )


class _Field:
    """A campaign under way."""

    def __init__(
        self,
        campaign: Campaign,
        fleet: Fleet,
        watch: Watch,
        store: Store,
        server: PostgresServer | None,
    ) -> None:
        self._campaign, self._fleet, self._watch, self._store = campaign, fleet, watch, store
        self.customer = Customer(fleet.url, fleet.token, fleet.time)
        self.calling: Calling | None = None
        if campaign.calls:
            self.calling = Calling(
                fleet, campaign.plant, campaign.calls, campaign.recurring, campaign.call_every_s
            )
        self.outages: list[Outage] = []
        self._breaker: Breaker | None = None
        if server is not None:
            pieces = single_pieces(campaign.plant)
            self._breaker = Breaker(server, fleet, watch, store, self.customer, pieces, campaign.dark_s)
        self._killed: list[tuple[Victim, float]] = []
        """Each victim with the moment of its kill (wall clock)."""

    async def play(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Play it; returns the quiet span and the span of the kills (plant clock)."""
        campaign = self._campaign
        orders = demand.orders(
            campaign.plant, Random(f"{campaign.seed} demand"), load=campaign.load, until_s=float("inf")
        )
        begun_s = self._now_s() - campaign.head_start_s
        # No task group: it would wrap the fleet's exception, which is reported as it is.
        placing = asyncio.create_task(self.customer.place(orders, begun_s))
        calling: asyncio.Task[None] | None = None
        try:
            await asyncio.sleep(campaign.warm_s)
            began_s = self._now_s()
            await asyncio.sleep(campaign.quiet_s)
            if self.calling is not None:
                await self.calling.prepare()
            kill_s = self._now_s()
            if self.calling is not None:
                calling = asyncio.create_task(self.calling.call())
            await self._kill_all()
            ended_s = self._now_s()
            if self.calling is not None and calling is not None:
                await calling
                # Orders go on: a load that is called back to a storage needs room there.
                await self.calling.see_out(campaign.drain_s)
            self.customer.stop()
            await placing
        finally:
            placing.cancel()
            if calling is not None:
                calling.cancel()
        await self._drain()
        return (began_s, kill_s), (kill_s, ended_s)

    @property
    def kills(self) -> list[Kill]:
        """All kills, in order, each with the next life where it is known."""
        to_plant_s = self._fleet.time.to_plant_s
        return [Kill(victim, to_plant_s(at_s), self._away_s(victim, at_s)) for victim, at_s in self._killed]

    async def _kill_all(self) -> None:
        campaign = self._campaign
        rota = Rota(Random(f"{campaign.seed} victims"), self._turns())
        latest_s = time.monotonic() + RETURN_S
        while len(self._killed) + len(self.outages) < campaign.kills:
            away = [victim.name for victim in self._away() if victim.kind not in LASTING]
            victim = rota.choose(self._living()) if len(away) < campaign.down else None
            if victim is not None and await self._kill(victim):
                latest_s = time.monotonic() + RETURN_S
            elif time.monotonic() > latest_s:
                gone = away if victim is None else [victim.name]
                reason = f"not back in {RETURN_S:.0f} s"
                raise UnavailableError(", ".join(gone), reason, self._fleet.last_words(gone[0]))
            await asyncio.sleep(campaign.pause_s)

    def _turns(self) -> dict[Kind, int]:
        campaign = self._campaign
        turns = dict.fromkeys(Kind, campaign.each) | dict.fromkeys(LASTING, campaign.lasting)
        del turns[Kind.CREW_VEHICLE]  # A crew vehicle goes when its machine does.
        if self._breaker is None:
            del turns[Kind.DATABASE]
        return turns

    async def _kill(self, victim: Victim) -> bool:
        """Kill it; False when it had ended by itself."""
        if victim.kind is Kind.DATABASE and self._breaker is not None:
            self.outages.append(await self._breaker.kill())
            return True
        if victim.kind in LASTING:
            killed = [victim] if await self._fleet.take_away(victim.name, self._campaign.lasting_s) else []
        else:
            killed = [each for each in (victim, *victim.crew) if self._fleet.kill(each.name)]
        self._killed += ((each, time.time()) for each in killed)
        return bool(killed)

    def _living(self) -> Iterator[Victim]:
        """Victims whose last life is on the bus.

        One with work is also listed as one that stays away, one of a kind at a time.
        """
        heard = self._watch.heard
        crews = (crew(each, heard.atvs.values()) for each in heard.machines.values())
        said = (
            *map(vehicle, heard.atvs.values()),
            *map(machine, heard.machines.values()),
            *filter(None, crews),
        )
        offices = (Victim(name, kind) for name, kind in OFFICES.items())
        away = self._away()
        gone, kinds = {victim.name for victim in away}, {victim.kind for victim in away}
        for victim in (*said, *offices):
            if gone.isdisjoint({victim.name, *(each.name for each in victim.crew)}):
                yield victim
                lasting = STAYS_AWAY.get(victim.kind)
                if victim.work and lasting is not None and lasting not in kinds:
                    yield replace(victim, kind=lasting)
        # Without a database these two do not start: their supervisor would be measured, and nothing else.
        if self._breaker is not None and gone.isdisjoint({GATEWAY, HISTORIAN}):
            yield DATABASE

    def _away(self) -> list[Victim]:
        """Victims whose last life is not on the bus yet."""
        last = {victim.name: (victim, at_s) for victim, at_s in self._killed}
        return [victim for victim, at_s in last.values() if self._away_s(victim, at_s) is None]

    def _away_s(self, victim: Victim, at_s: float) -> float | None:
        joined_s = self._watch.joined_since(victim.name, at_s)
        return None if joined_s is None else joined_s - at_s

    async def _drain(self) -> None:
        """Wait for the last orders and the last lives, and give up when no piece arrives for too long."""
        arrived, since_s = -1, time.monotonic()
        while time.monotonic() < since_s + self._campaign.drain_s:
            orders = await _all_orders(self._store)
            there = all(kill.away_s is not None for kill in self.kills)
            if there and all(order.status is OrderStatus.DELIVERED for order in orders):
                return
            pieces = sum(sum(order.delivered) for order in orders)
            if pieces > arrived:
                arrived, since_s = pieces, time.monotonic()
            await asyncio.sleep(LOOK_S)

    def _now_s(self) -> float:
        return self._fleet.time.to_plant_s(time.time())


async def _all_orders(store: Store) -> list[Order]:
    async with store.read() as work:
        return await work.orders.page(EVERY_ORDER, None, None)
