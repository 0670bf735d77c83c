"""A whole factory whose agents meet on Zenoh: its stories end as on the simulated network."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Coroutine
from dataclasses import replace
from itertools import count, cycle
from typing import Any

import pytest
from zenoh_kit import Row, run_patiently

from dray.messages import Event, Message, OrderItem, Phase
from dray.messages.fact import (
    AnyFact,
    CarrierChanged,
    ContractorRated,
    OrderFulfilled,
    PhaseEntered,
    TaskClosed,
)
from dray.plant import default_plant
from dray.ports import Bus, Receive, Session
from dray_sim.checks.invariants import Invariants
from dray_sim.clock.loop import clock, run
from dray_sim.factory.sim_factory import SimFactory
from dray_sim.insiders import BEHAVIOURS
from dray_sim.insiders.joining import INSIDER, bring_in
from dray_sim.network.listeners import Listener, Listeners
from dray_sim.people.demand import Order
from dray_sim.people.order_client import OrderClient

PLANT = default_plant()

SPEED = 25.0
"""Factory seconds per real one: an order takes some real seconds."""

LATEST_S = 3600.0
"""No story takes so long (plant clock)."""

SESSIONS = 3
"""In a row, so that a third of the agents hear another third by relay."""

ORDER = Order("O-1", 0.0, LATEST_S, (OrderItem("gear-unit-g1", 2),))


class Overheard:
    """A place on a bus, and a listener that hears what is said there."""

    def __init__(self, inner: Session, agent: str, listener: Listener) -> None:
        self._inner, self._agent, self._listener = inner, agent, listener
        self.subscribe, self.unsubscribe, self.leave = inner.subscribe, inner.unsubscribe, inner.leave

    def publish(self, key: str, message: Message) -> None:
        self._listener.on_message(clock().now_s(), self._agent, key, message)
        self._inner.publish(key, message)

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


Story = Callable[[Stage], Coroutine[Any, Any, object]]


async def tell(story: Story, factory: SimFactory, bus: Bus, listeners: Listeners) -> object:
    """Tell a story; it ends by itself, or with the first broken invariant."""
    checks, stage = Invariants(factory), Stage(factory, bus)
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
    async def main() -> object:
        listeners = Listeners()
        factory = SimFactory(PLANT, clock(), seed=1, listener=listeners)
        return await tell(story, factory, factory.bus, listeners)

    return run(main())


def on_zenoh(story: Story) -> object:
    async def main() -> object:
        listeners, row = Listeners(), Row(SESSIONS, PLANT.id)
        bus = Spread(row, listeners)
        try:
            told = await tell(story, SimFactory(PLANT, clock(), seed=1, meet=lambda _: bus), bus, listeners)
            assert [(dict(zenoh.refused), zenoh.missed) for zenoh in row.buses] == [({}, 0)] * SESSIONS
            return told
        finally:
            row.close()

    return run_patiently(main(), SPEED)


async def an_order_is_delivered(stage: Stage) -> object:
    """What was delivered, and how each of its transports ended."""
    await stage.customers.order(ORDER)
    _, fulfilled = await stage.until(lambda _, fact: isinstance(fact, OrderFulfilled))
    arrived = {name: dict(warehouse.arrived) for name, warehouse in stage.factory.delivery.items()}
    ends = {fact.outcome for _, fact in stage.facts if isinstance(fact, TaskClosed)}
    return fulfilled, arrived, ends


async def a_vehicle_dies_on_its_way(stage: Stage) -> object:
    """What was delivered, though the first vehicle that had set off for the order has died at once."""
    await stage.customers.order(ORDER)
    dead, entered = await stage.until(
        lambda _, fact: isinstance(fact, PhaseEntered) and fact.phase is Phase.APPROACHING
    )
    assert isinstance(entered, PhaseEntered)
    stage.factory.power_off(dead)
    _, changed = await stage.until(
        lambda _, fact: isinstance(fact, CarrierChanged) and fact.task == entered.task
    )
    assert isinstance(changed, CarrierChanged)
    _, fulfilled = await stage.until(lambda _, fact: isinstance(fact, OrderFulfilled))
    arrived = {name: dict(warehouse.arrived) for name, warehouse in stage.factory.delivery.items()}
    return fulfilled, arrived, changed.carrier != dead


@pytest.mark.parametrize("story", [an_order_is_delivered, a_vehicle_dies_on_its_way])
def test_a_story_ends_alike_on_both_buses(story: Story) -> None:
    assert on_zenoh(story) == on_the_simulated_network(story)


def was_dropped(_agent: str, fact: AnyFact) -> bool:
    return isinstance(fact, ContractorRated) and fact.contractor == INSIDER


async def more_orders_until_it_is_dropped(stage: Stage) -> None:
    """On a busy computer its bids may come too late for all transports of one order; they are not for ever."""
    for number in count(2):
        if any(was_dropped(*each) for each in stage.facts):
            return
        order = replace(ORDER, id=f"O-{number}")
        await stage.customers.order(order)
        await stage.until(
            lambda agent, fact, order=order: (
                was_dropped(agent, fact) or (isinstance(fact, OrderFulfilled) and fact.order == order.id)
            )
        )


def beside(behaviour: str, drops: bool) -> Story:
    """An order is delivered, though a vehicle lies that has joined as any other; whether it is given contracts to drop."""

    async def story(stage: Stage) -> object:
        liar = asyncio.create_task(bring_in(stage.factory, BEHAVIOURS[behaviour], stage.bus).run())
        try:
            await stage.until_heard(INSIDER)
            told = await an_order_is_delivered(stage)
            if drops:
                await more_orders_until_it_is_dropped(stage)
        finally:
            liar.cancel()
        assert drops or not any(was_dropped(*each) for each in stage.facts)
        return told

    return story


@pytest.mark.parametrize(("behaviour", "drops"), [("bids-nothing", False), ("bids-the-least", True)])
def test_a_liar_on_the_real_bus_keeps_no_order_from_being_delivered(behaviour: str, drops: bool) -> None:
    assert on_zenoh(beside(behaviour, drops)) == on_the_simulated_network(an_order_is_delivered)
