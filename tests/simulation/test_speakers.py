"""The table of who may say what is that of the protocol: nobody says in a whole factory what it may not."""

from __future__ import annotations

import asyncio
import typing
from collections import defaultdict
from random import Random

from dray.messages import AnyMessage, Message
from dray.messages.speakers import SPEAKERS, Kind
from dray.plant import Plant, default_plant
from dray.protocol.strategist import STRATEGIST
from dray_sim import demand
from dray_sim.desk import Desk
from dray_sim.factory import SimFactory
from dray_sim.loop import clock, run

SPAN_S = 7200.0
"""Of work and trouble: by then takeovers, lost goals and new elections have all been seen."""


class Ear:
    """Who has said what."""

    def __init__(self, plant: Plant) -> None:
        self.said: defaultdict[type[Message], set[Kind]] = defaultdict(set)
        self._kinds = {
            **dict.fromkeys(plant.fleet, Kind.ATV),
            **dict.fromkeys(plant.machines, Kind.MACHINE),
            STRATEGIST: Kind.STRATEGIST,
        }

    def hear(self, at_s: float, sender: str, address: str, message: Message) -> None:
        if kind := self._kinds.get(sender):
            self.said[type(message)].add(kind)


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
    assert set(SPEAKERS) == set(typing.get_args(AnyMessage))
    assert all(SPEAKERS.values())


def test_nobody_says_in_a_troubled_factory_what_it_may_not() -> None:
    plant = default_plant()
    ear = Ear(plant)

    async def main() -> None:
        factory = SimFactory(plant, clock(), seed=1, ear=ear)
        customers = Desk(factory.bus, clock())
        orders = demand.orders(plant, Random(1), load=0.8, until_s=SPAN_S)
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
    overstepped = {kind.__name__: said - SPEAKERS[kind] for kind, said in ear.said.items()}
    assert not any(overstepped.values()), overstepped
    # Nothing of the negotiation is left out of the test.
    assert len(ear.said) >= 20, sorted(kind.__name__ for kind in ear.said)
