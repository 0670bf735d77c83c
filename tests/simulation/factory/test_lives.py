"""Agents that end and begin again at any moment of a running factory, and a history without holes."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Iterable
from contextlib import asynccontextmanager
from random import Random
from typing import cast

import pytest
from variants import variants

from dray.messages import AtvHeartbeat, DwellPointClaimed, Event, Heartbeat, Message
from dray.messages.history import HISTORY_KEPT
from dray.messages.keys import STRATEGIST
from dray.plant import default_plant
from dray.ports import Receive, Session
from dray.store import Historian, Store
from dray.store.history.gaps import LIVES, TAIL_S, Known
from dray.store.orders.goals import Goal
from dray.store.orders.orders import Order
from dray_sim.checks.invariants import Invariants
from dray_sim.clock.loop import clock, run
from dray_sim.factory.journal import HeldJournal
from dray_sim.factory.sim_factory import SimFactory
from dray_sim.network.listeners import Listener, Listeners
from dray_sim.network.sim_network import SimNetwork
from dray_sim.people import demand
from dray_sim.people.order_client import OrderClient

SPAN_S = 1800.0
"""Of trouble: some hundred lives end in it."""

SETTLE_S = 300.0
"""After it. By then the historian has asked everybody about everything."""

FETCHED_S = 2 * TAIL_S
"""What happened so long ago was fetched if it was missed, though answers get lost too."""

BEAT_S = 10.0
"""A living agent is heard more often than this, whatever it does."""

Key = tuple[str, int, int]


def key(event: Event) -> Key:
    """What no two events have in common."""
    return event.agent, event.incarnation, event.number


class Shelf:
    """What the historian writes, in memory: a store for virtual time, where no thread of a database can run."""

    def __init__(self) -> None:
        self.kept: dict[Key, Event] = {}

    @asynccontextmanager
    async def read(self) -> AsyncIterator[Shelf]:
        yield self

    write = read

    @property
    def events(self) -> Shelf:
        return self

    samples = orders = goals = transports = tasks = piece_hours = takeovers = events

    async def add(self, told: Iterable[Event | Heartbeat], _to_wall_s: object) -> None:
        for one in told:
            if isinstance(one, Event):
                self.kept.setdefault(key(one), one)

    async def known(self) -> list[Known]:
        lives: dict[tuple[str, int], set[int]] = {}
        for agent, life, number in self.kept:
            lives.setdefault((agent, life), set()).add(number)
        return [
            Known(agent, life, max(there), tuple(sorted(set(range(1, max(there))) - there))[-HISTORY_KEPT:])
            for (agent, life), there in sorted(lives.items())
            if life + LIVES > max(other for name, other in lives if name == agent)
        ]

    async def accept(self, _lives: dict[str, int]) -> None:
        """No orders here."""

    async def many(self, _ids: Iterable[str]) -> dict[str, Goal]:
        return {}

    async def put(self, _goals: Iterable[Goal]) -> None:
        """No goals here."""

    async def of_orders(self, _orders: Iterable[str]) -> dict[str, list[Goal]]:
        return {}

    async def advance(self, _order: Order, _progress: object) -> None:
        """No orders here."""

    async def follow(self, _events: Iterable[Event], _to_wall_s: object) -> None:
        """No transports here."""


class Deafened:
    """A bus on which its only agent misses every fifth message."""

    def __init__(self, bus: SimNetwork, chance: Random) -> None:
        self._bus, self._chance = bus, chance

    def join(self, agent: str, receive: Receive, life: int = 0) -> Session:
        def on_message(sender: str, message: Message) -> None:
            if self._chance.random() >= 0.2:
                receive(sender, message)

        return self._bus.join(agent, on_message, life)


class Beats:
    """Hears whether all that live say so.

    Attributes:
        longest_s: the longest silence of an agent that lived all the time, with its name.
    """

    def __init__(self) -> None:
        self.factory: SimFactory
        self.longest_s: tuple[float, str] = (0.0, "")
        self._heard: dict[str, tuple[float, int]] = {}

    def on_message(self, at_s: float, sender: str, _address: str, message: Message) -> None:
        if not isinstance(message, Heartbeat):
            return
        agent = message.atv if isinstance(message, AtvHeartbeat) else message.machine
        before_s, life = self._heard.get(agent, (at_s, 0))
        if life == message.incarnation:
            self.longest_s = max(self.longest_s, (at_s - before_s, agent))
        self._heard[agent] = (at_s, message.incarnation)

    def silent(self, now_s: float) -> list[str]:
        """Agents that live and were not heard lately."""
        agents = (*self.factory.vehicles, *self.factory.workcells)
        return [agent for agent in agents if now_s - self._heard[agent][0] > BEAT_S]


class FirstTime:
    """A listener that does not hear what is told again to one agent alone."""

    def __init__(self, listener: Listener) -> None:
        self._listener = listener

    def on_message(self, at_s: float, sender: str, address: str, message: Message) -> None:
        if not (isinstance(message, Event) and address.startswith(">")):
            self._listener.on_message(at_s, sender, address, message)


async def trouble(factory: SimFactory, chance: Random) -> None:
    """End agents of every kind, at any moment and for any time, until it is enough."""
    bodies = (*factory.vehicles, *factory.workcells)

    async def one(agent: str) -> None:
        if agent != STRATEGIST and chance.random() < 0.3:
            factory.power_off(agent)
            await asyncio.sleep(chance.uniform(0.0, 60.0))
            factory.power_on(agent)
            return
        if chance.random() < 0.7:
            factory.crash(agent)
            await asyncio.sleep(chance.choice((0.0, chance.uniform(0.0, 2.0), chance.uniform(0.0, 60.0))))
        factory.restart(agent, software=chance.choice(("", "1.9", "2.0")))

    async with asyncio.TaskGroup() as group:
        while factory.clock.now_s() < SPAN_S:
            await asyncio.sleep(chance.expovariate(1 / 15.0))
            agent = STRATEGIST if chance.random() < 0.1 else chance.choice(bodies)
            group.create_task(one(agent))


@asynccontextmanager
async def historian(shelf: Shelf, factory: SimFactory, chance: Random) -> AsyncIterator[Historian]:
    made = Historian(
        store=cast(Store, shelf),
        bus=Deafened(factory.bus, chance),
        keys=factory.keys,
        to_wall_s=lambda plant_s: plant_s,
        agents=tuple(factory.workers),
    )
    async with made.running():
        yield made


async def attend(shelf: Shelf, factory: SimFactory, chance: Random) -> Historian:
    """A historian that is away now and then; the last one, when the trouble is over and all is fetched."""
    while factory.clock.now_s() < SPAN_S:
        async with historian(shelf, factory, chance):
            await asyncio.sleep(chance.uniform(0.0, 200.0))
        await asyncio.sleep(chance.uniform(0.0, 100.0))
    async with historian(shelf, factory, chance) as last:
        await asyncio.sleep(SETTLE_S)
    return last


@pytest.mark.parametrize("seed", variants(range(3)))
def test_agents_end_and_begin_at_any_moment_and_the_history_has_no_holes(seed: int) -> None:
    async def main() -> None:
        plant, listeners, beats, shelf = default_plant(), Listeners(), Beats(), Shelf()
        factory = beats.factory = SimFactory(plant, clock(), seed=seed, listener=listeners)
        checks = Invariants(factory)
        listeners.add(FirstTime(checks), beats)
        orders = demand.orders(plant, Random(f"{seed} demand"), load=0.9, until_s=SPAN_S)
        async with asyncio.TaskGroup() as group:
            life = group.create_task(factory.run())
            customers = group.create_task(OrderClient(factory.bus, factory.clock).place(orders))
            group.create_task(trouble(factory, Random(f"{seed} trouble")))
            last = await attend(shelf, factory, Random(f"{seed} historian"))
            assert checks.broken is None
            assert beats.silent(factory.clock.now_s()) == []
            assert beats.longest_s[0] <= BEAT_S, beats.longest_s
            assert min(journal.incarnation for journal in factory.journals.values()) >= 1
            assert sum(journal.incarnation - 1 for journal in factory.journals.values()) > 50
            assert (last.gone, last.lost) == (0, 0)
            until_s = factory.clock.now_s() - FETCHED_S
            told = [event for journal in factory.journals.values() for event in written(journal)]
            assert {key(event): event for event in told if event.at_s < until_s} == {
                name: event for name, event in shelf.kept.items() if event.at_s < until_s
            }
            for task in (life, customers):
                task.cancel()

    run(main())


def written(journal: HeldJournal) -> list[Event]:
    """All that an agent has written down, in all its lives."""
    events = [
        event for life in range(1, journal.incarnation + 1) for event in journal.events(life, 1, 10_000)
    ]
    assert len(events) < 1_000, "the journal has forgotten some: make the run shorter"
    return events


async def _begun_twice_at_once() -> int:
    """How often a vehicle says that it stands where it stands, after two restarts in one instant."""
    claims: list[DwellPointClaimed] = []
    listeners = Listeners()
    listeners.add(Claims("ATV1", claims))
    factory = SimFactory(default_plant(), clock(), seed=1, listener=listeners)
    living = asyncio.create_task(factory.run())
    await asyncio.sleep(BEAT_S)
    claims.clear()
    factory.restart("ATV1")
    factory.restart("ATV1")
    await asyncio.sleep(BEAT_S)
    living.cancel()
    await asyncio.gather(living, return_exceptions=True)
    return len(claims)


class Claims:
    """Keeps the claims of one vehicle."""

    def __init__(self, atv: str, claims: list[DwellPointClaimed]) -> None:
        self._atv, self._claims = atv, claims

    def on_message(self, _at_s: float, sender: str, _address: str, message: Message) -> None:
        if sender == self._atv and type(message) is DwellPointClaimed:
            self._claims.append(message)


def test_a_life_that_ends_before_it_has_begun_is_not_lived_and_the_next_one_is_lived_once() -> None:
    assert run(_begun_twice_at_once()) == 1
