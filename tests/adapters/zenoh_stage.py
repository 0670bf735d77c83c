"""A whole factory whose agents meet on Zenoh, in one process and a row of sessions: a stage for stories."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Coroutine, Iterable
from itertools import cycle
from typing import Any

from zenoh_kit import Row, run_patiently

from dray.adapters.zenoh.bus import ZenohSession
from dray.messages import Event, Message
from dray.messages.fact import AnyFact
from dray.plant import default_plant
from dray.ports import Bus, Receive, Session
from dray_sim.checks.invariants import Invariants
from dray_sim.clock.loop import clock, run
from dray_sim.factory.sim_factory import SimFactory
from dray_sim.network.listeners import Listener, Listeners
from dray_sim.people.order_client import OrderClient

PLANT = default_plant()

SPEED = 25.0
"""Factory seconds per real one: an order takes some real seconds."""

LATEST_S = 3600.0
"""No story takes so long (plant clock)."""

SESSIONS = 3
"""In a row, so that a third of the agents hear another third by relay."""


class Overheard:
    """A place on a bus, and a listener that hears what is said there."""

    def __init__(self, inner: Session, agent: str, listener: Listener) -> None:
        self._inner, self._agent, self._listener = inner, agent, listener
        self.subscribe, self.unsubscribe, self.leave = inner.subscribe, inner.unsubscribe, inner.leave

    def publish(self, key: str, message: Message) -> None:
        self._listener.on_message(clock().now_s(), self._agent, key, message)
        self._inner.publish(key, message)

    def take_name(self, agent: str) -> None:
        """Speak under another's name from now on, unheard by the listener."""
        assert isinstance(self._inner, ZenohSession)
        self._agent = self._inner.agent = agent
        self._listener = Listeners()

    def send(self, to: str, message: Message) -> None:
        self._listener.on_message(clock().now_s(), self._agent, f">{to}", message)
        self._inner.send(to, message)


class Spread:
    """A bus of several Zenoh sessions, with every so manyth agent each."""

    def __init__(self, row: Row, listener: Listener) -> None:
        self._turns, self._listener = cycle(row.buses), listener

    def join(self, agent: str, receive: Receive, life: int = 0) -> Overheard:
        return Overheard(next(self._turns).join(agent, receive, life), agent, self._listener)


class Stage:
    """A factory in which a story is told."""

    def __init__(self, factory: SimFactory, bus: Bus) -> None:
        self.factory, self.bus, self.customers = factory, bus, OrderClient(bus, factory.clock)
        self.facts: list[tuple[str, AnyFact]] = []
        self.heard: set[str] = set()
        """Who has said anything to all."""
        self._told = asyncio.Event()

    def on_message(self, at_s: float, sender: str, address: str, message: Message) -> None:
        if sender not in self.heard:
            self.heard.add(sender)
            self._told.set()
        if isinstance(message, Event) and address.startswith(PLANT.id):
            self.facts.append((sender, message.fact))
            self._told.set()

    async def until(self, seen: Callable[[str, AnyFact], bool]) -> tuple[str, AnyFact]:
        """The first fact of this sort, whether it is told already or not."""
        looked = 0
        while True:
            for agent, fact in self.facts[looked:]:
                if seen(agent, fact):
                    return agent, fact
            looked = len(self.facts)
            self._told.clear()
            await self._told.wait()

    async def until_heard(self, agent: str) -> None:
        """Wait until it has said something to all."""
        while agent not in self.heard:
            self._told.clear()
            await self._told.wait()


Checks = Callable[[SimFactory], Iterable[Listener]]
"""Makes what watches a story beside the usual invariants."""


def no_more(_factory: SimFactory) -> Iterable[Listener]:
    """Nothing beside the usual invariants."""
    return ()


Story = Callable[[Stage], Coroutine[Any, Any, object]]


async def tell(
    story: Story, factory: SimFactory, bus: Bus, listeners: Listeners, more: Iterable[Listener] = ()
) -> object:
    """Tell a story; it ends by itself, or with the first broken invariant."""
    checks, stage = Invariants(factory, *more), Stage(factory, bus)
    listeners.add(checks, stage)
    async with asyncio.timeout(LATEST_S), asyncio.TaskGroup() as group:
        life = group.create_task(factory.run())
        ending = group.create_task(story(stage))
        watch = group.create_task(checks.wait_broken())
        await asyncio.wait((ending, watch), return_when=asyncio.FIRST_COMPLETED)
        checks.check_end(clock().now_s())
        for task in (life, ending, watch):
            task.cancel()
    if checks.broken is not None:
        raise checks.broken
    return ending.result()


def on_the_simulated_network(story: Story) -> object:
    """Tell it there, as fast as it goes."""

    async def main() -> object:
        listeners = Listeners()
        factory = SimFactory(PLANT, clock(), seed=1, listener=listeners)
        return await tell(story, factory, factory.bus, listeners)

    return run(main())


def on_zenoh(story: Story, *, traffic: bool = False, checks: Checks = no_more) -> object:
    """Tell it there; nothing may be refused or lost."""

    async def main() -> object:
        listeners, row = Listeners(), Row(SESSIONS, PLANT.id)
        bus = Spread(row, listeners)
        try:
            factory = SimFactory(PLANT, clock(), seed=1, meet=lambda _: bus, traffic=traffic)
            told = await tell(story, factory, bus, listeners, checks(factory))
            assert [(dict(zenoh.refused), zenoh.missed) for zenoh in row.buses] == [({}, 0)] * SESSIONS
            return told
        finally:
            row.close()

    return run_patiently(main(), SPEED)
