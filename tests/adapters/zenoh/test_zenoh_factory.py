"""A whole factory whose agents meet on Zenoh: its stories end as on the simulated network."""

from __future__ import annotations

import asyncio
from dataclasses import replace
from itertools import count

import pytest
from zenoh_stage import LATEST_S, Stage, Story, on_the_simulated_network, on_zenoh

from dray.messages import OrderItem, Phase
from dray.messages.fact import (
    AnyFact,
    CarrierChanged,
    ContractorRated,
    OrderFulfilled,
    PhaseEntered,
    TaskClosed,
)
from dray_sim.insiders import BEHAVIOURS
from dray_sim.insiders.joining import INSIDER, bring_in
from dray_sim.people.demand import Order

ORDER = Order("O-1", 0.0, LATEST_S, (OrderItem("gear-unit-g1", 2),))


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


@pytest.mark.parametrize(
    "story", [pytest.param(an_order_is_delivered, marks=pytest.mark.slow), a_vehicle_dies_on_its_way]
)
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


@pytest.mark.parametrize(
    ("behaviour", "drops"),
    [pytest.param("bids-nothing", False, marks=pytest.mark.slow), ("bids-the-least", True)],
)
def test_a_liar_on_the_real_bus_keeps_no_order_from_being_delivered(behaviour: str, drops: bool) -> None:
    assert on_zenoh(beside(behaviour, drops)) == on_the_simulated_network(an_order_is_delivered)
