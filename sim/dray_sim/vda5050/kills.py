"""Kills and restarts of agents, vehicles and brokers in any order, behind a proxy that spoils messages: is all work done exactly once?

The default plant at its full load, its vehicles of VDA 5050 2.0, 2.1 and 3.0 by turns, in virtual time: everything follows from the seed.
"""

from __future__ import annotations

import asyncio
from collections import Counter
from dataclasses import dataclass, field
from random import Random

from dray.messages import Event, Message
from dray.messages.fact import TaskClosed, TaskOpened
from dray.plant import Plant
from dray_sim.bodies.floor import NEARLY_EMPTY_FRAC
from dray_sim.checks.invariants import Invariants
from dray_sim.clock.loop import JUMP, clock, run
from dray_sim.factory.sim_factory import SimFactory
from dray_sim.network.listeners import Listeners
from dray_sim.people import demand
from dray_sim.people.order_client import OrderClient
from dray_sim.vda5050.broker_fleet import all_versions
from dray_sim.vda5050.fleet import MemoryFleet
from dray_sim.vda5050.proxy import Proxy

EVERY_S = 20.0
"""Mean time from one kill to the next."""

AGENT_AWAY_S, BROKER_AWAY_S = 5.0, 20.0
"""Longest absence; then it is started again."""

ALL_FRAC = 0.2
"""Fraction of the brokers' ends that affect every vehicle: the broker is a common one."""

SETTLE_S = 3600.0
"""Time afterwards, with links that work and no new orders, in which all work comes to its end."""


@dataclass
class Outcome:
    """The results of a run.

    Attributes:
        kills: by the kind of the victim.
        messages: number of the proxy's actions, by kind.
        opened, closed: tasks; closed ones by their outcome.
        actions: that vehicles have carried out.
        twice: actions that a vehicle carried out more than once.
        broken: an invariant, in words; empty for none.
    """

    kills: Counter[str] = field(default_factory=Counter)
    messages: Counter[str] = field(default_factory=Counter)
    opened: set[str] = field(default_factory=set)
    closed: dict[str, list[str]] = field(default_factory=dict)
    actions: int = 0
    twice: list[str] = field(default_factory=list)
    broken: str = ""

    @property
    def failures(self) -> list[str]:
        """Violations; empty for none."""
        left = sorted(self.opened - self.closed.keys())
        often = sorted(task for task, outcomes in self.closed.items() if outcomes.count("delivered") > 1)
        return [
            *([self.broken] if self.broken else []),
            *(f"action {action} was carried out twice" for action in self.twice),
            *(f"task {task} was delivered more than once" for task in often),
            *(f"task {task} has not ended" for task in left),
        ]

    @property
    def outcomes(self) -> Counter[str]:
        """The outcomes of tasks."""
        return Counter(outcomes[-1] for outcomes in self.closed.values())

    def on_message(self, _at_s: float, _sender: str, _address: str, message: Message) -> None:
        """See `Listener`."""
        if type(message) is not Event:
            return
        fact = message.fact
        if type(fact) is TaskOpened:
            self.opened.add(fact.task)
        elif type(fact) is TaskClosed:
            self.closed.setdefault(fact.task, []).append(fact.outcome)


def play(plant: Plant, seed: int, kills: int, *, traffic: bool = False) -> Outcome:
    """Kill so many, one after the other, and examine the state after all have settled."""
    return run(_played(plant, seed, kills, traffic=traffic), JUMP)


async def _played(plant: Plant, seed: int, kills: int, *, traffic: bool) -> Outcome:
    outcome, now, chance = Outcome(), clock(), Random(f"{seed} kills")
    profiles, order = all_versions(), sorted(plant.fleet)
    proxy = Proxy(now, Random(f"{seed} proxy"))
    fleet = MemoryFleet(plant, now, lambda atv: profiles[order.index(atv) % len(profiles)], carry=proxy.carry)
    listeners = Listeners()
    factory = SimFactory(
        plant,
        now,
        seed=seed,
        stock_frac=NEARLY_EMPTY_FRAC,
        listener=listeners,
        traffic=traffic,
        embody=fleet.embody,
    )
    invariants = Invariants(factory)
    listeners.add(outcome, invariants)
    span_s = kills * EVERY_S
    wanted = list(demand.orders(plant, Random(seed), load=0.7, until_s=span_s))
    running = asyncio.create_task(factory.run())
    customers = asyncio.create_task(OrderClient(factory.bus, now).place(wanted))
    killer = _Killer(factory, fleet, proxy, chance, outcome.kills)
    try:
        async with asyncio.TaskGroup() as group:
            for _ in range(kills):
                await asyncio.sleep(chance.uniform(0.0, 2.0 * EVERY_S))
                group.create_task(killer.kill())
        proxy.quiet = True
        await asyncio.sleep(SETTLE_S)
        if running.done():
            running.result()
        invariants.check_end(now.now_s())
    except Exception as error:  # noqa: BLE001  The search looks for any end of an agent.
        outcome.broken = f"{type(error).__name__}: {error}"
    outcome.broken = outcome.broken or (str(invariants.broken) if invariants.broken else "")
    outcome.messages = proxy.did
    for vehicle in fleet.vehicles.values():
        outcome.actions += len(vehicle.done)
        outcome.twice += [action for action, count in Counter(vehicle.done).items() if count > 1]
    for task in (running, customers):
        task.cancel()
    await asyncio.gather(running, customers, return_exceptions=True)
    return outcome


class _Killer:
    """Ends one thing, and starts it again after a while."""

    def __init__(
        self, factory: SimFactory, fleet: MemoryFleet, proxy: Proxy, chance: Random, kills: Counter[str]
    ) -> None:
        self._factory, self._fleet, self._proxy = factory, fleet, proxy
        self._chance, self._kills = chance, kills
        self._crashed: set[str] = set()

    async def kill(self) -> None:
        """Whichever it hits."""
        atv = self._chance.choice(sorted(self._fleet.vehicles))
        what = self._chance.choice(("agent", "vehicle", "broker"))
        if what == "vehicle":
            self._kills["vehicle"] += 1
            self._fleet.vehicles[atv].restart()
        elif what == "agent" and atv not in self._crashed:
            await self._agent(atv)
        else:
            await self._broker(atv)

    async def _agent(self, atv: str) -> None:
        self._kills["agent"] += 1
        self._crashed.add(atv)
        self._factory.crash(atv)
        await asyncio.sleep(self._chance.uniform(0.0, AGENT_AWAY_S))
        while atv in self._proxy.down:  # noqa: ASYNC110  Brokers come back by the clock alone.
            await asyncio.sleep(1.0)  # The vehicle waits for its broker.
        self._crashed.discard(atv)
        self._factory.restart(atv)

    async def _broker(self, atv: str) -> None:
        everyone = self._chance.random() < ALL_FRAC
        atvs = sorted(self._fleet.vehicles) if everyone else [atv]
        gone = [one for one in atvs if one not in self._proxy.down]
        self._kills["broker of all" if everyone else "broker"] += 1
        self._proxy.down.update(gone)
        for one in gone:
            self._fleet.bodies[one].on_link_lost("killed")
        await asyncio.sleep(self._chance.uniform(0.5, BROKER_AWAY_S))
        self._proxy.down.difference_update(gone)
        for one in gone:
            self._fleet.vehicles[one].introduce()
            self._fleet.bodies[one].on_link()
