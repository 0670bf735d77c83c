"""The table of who may say what is that of the protocol: nobody says in a whole factory what it may not."""

from __future__ import annotations

import asyncio
import typing
from collections import Counter
from random import Random

import pytest

from dray.messages import (
    AnyFact,
    AnyMessage,
    CallAnswered,
    CommandAnswered,
    Event,
    Fact,
    HelpCall,
    Message,
    OperatorHeartbeat,
    Removal,
    Removals,
    StationHeartbeat,
    StrategistHeartbeat,
)
from dray.messages.fact import CommandObeyed
from dray.messages.kinds import Kind
from dray.plant import default_plant
from dray_sim.clock.loop import clock, run
from dray_sim.factory.sim_factory import SimFactory
from dray_sim.people import demand
from dray_sim.people.order_client import OrderClient

SPAN_S = 7200.0
"""Of work and trouble: by then takeovers, lost goals and new elections have all been seen."""


class Listener:
    """The words and the facts that were heard."""

    def __init__(self) -> None:
        self.said: set[type[Message]] = set()
        self.told: set[type[Fact]] = set()

    def on_message(self, at_s: float, sender: str, address: str, message: Message) -> None:
        self.said.add(type(message))
        if isinstance(message, Event):
            self.told.add(type(message.fact))


async def trouble(factory: SimFactory, random: Random) -> None:
    """Agents end and begin again, the strategist too."""
    agents = sorted(factory.workers)
    while True:
        await asyncio.sleep(random.uniform(10.0, 40.0))
        agent = random.choice(agents)
        factory.crash(agent)
        await asyncio.sleep(random.uniform(1.0, 20.0))
        factory.restart(agent)


def test_every_message_has_its_speakers() -> None:
    assert [kind for kind in typing.get_args(AnyMessage) if not kind.said_by] == []


def test_every_fact_has_its_tellers() -> None:
    assert [kind for kind in typing.get_args(AnyFact) if not kind.told_by] == []


def test_whoever_obeys_a_word_may_answer_it() -> None:
    assert CommandAnswered.said_by == CommandObeyed.told_by


def test_every_field_that_says_who_speaks_is_compared_with_the_speaker() -> None:
    names = {"atv", "machine", "coordinator", "agent"}
    # A word about a dock names whose it is, also where a vehicle says it.
    found = {
        StationHeartbeat: "station",
        StrategistHeartbeat: "strategist",
        OperatorHeartbeat: "operator",
        HelpCall: "caller",
        CallAnswered: "operator",
    } | {
        kind: field
        for kind in typing.get_args(AnyMessage)
        for field in kind.__struct_fields__
        if field in names
    }
    assert found == {kind: kind.signed for kind in typing.get_args(AnyMessage) if kind.signed}


def test_without_a_signature_of_people_a_gateway_gives_orders_and_hints_and_moves_nothing() -> None:
    """So much is believed of who has its certificate, and not the key in its database."""
    signed = {"grant", "signature"}
    bare = {
        kind.__name__
        for kind in typing.get_args(AnyMessage)
        if Kind.GATEWAY in kind.said_by and signed.isdisjoint(kind.__struct_fields__)
    }
    orders = {
        "OrderReleased",
        "OrderRevoked",
        "OrderCancelled",
        "TransportOrdered",
        "TransportCancelled",
    }
    assert "grant" in Removal.__struct_fields__
    assert bare == orders | {"ShutOut", "ObstacleCleared", "EventsAsked", Removals.__name__}


@pytest.mark.slow
def test_nobody_says_in_a_troubled_factory_what_it_may_not() -> None:
    plant = default_plant()
    listener = Listener()
    refused: list[Counter[str]] = []

    async def main() -> None:
        factory = SimFactory(plant, clock(), seed=1, listener=listener)
        customers = OrderClient(factory.bus, clock())
        orders = demand.orders(plant, Random(1), load=0.8, until_s=SPAN_S)
        refused.append(factory.bus.refused)
        async with asyncio.TaskGroup() as group:
            tasks = [
                group.create_task(factory.run()),
                group.create_task(customers.place(orders)),
                group.create_task(trouble(factory, Random(1))),
            ]
            await asyncio.sleep(SPAN_S)
            for task in tasks:
                task.cancel()

    run(main())
    assert not refused[0]
    # Nothing of the negotiation is left out of the test.
    assert len(listener.said) >= 20, sorted(kind.__name__ for kind in listener.said)
    assert len(listener.told) >= 20, sorted(kind.__name__ for kind in listener.told)
