"""The gate is killed again and again, on a bad link, and every piece that an order has asked for is delivered and told once."""

from __future__ import annotations

import asyncio
from collections import Counter
from random import Random

import pytest
from variants import variants

from dray.messages import Event, Message
from dray.messages.fact import GoodsDelivered, OrderFulfilled
from dray.messages.keys import GATE, STRATEGIST
from dray.plant import load_plant
from dray_sim.checks.invariants import Invariants
from dray_sim.clock.loop import clock, run
from dray_sim.factory.sim_factory import SimFactory
from dray_sim.network.faults import LinkTrouble
from dray_sim.network.listeners import Listeners
from dray_sim.people import demand
from dray_sim.people.order_client import OrderClient

PLACED_S, TROUBLE_S, ENDED_S = 900.0, 2400.0, 9000.0

LOSSY = (
    LinkTrouble(sender=GATE, loss_frac=0.3, duplicate_frac=0.1, latency_s=1.0),
    LinkTrouble(receiver=GATE, loss_frac=0.3, duplicate_frac=0.1, latency_s=1.0),
)


class Told:
    """What strategists tell as delivered, by product, and which orders as fulfilled."""

    def __init__(self, orders: int) -> None:
        self._orders, self.all = orders, asyncio.Event()
        self.delivered: Counter[str] = Counter()
        self.fulfilled: Counter[str] = Counter()

    def on_message(self, _at_s: float, _sender: str, address: str, message: Message) -> None:
        if not isinstance(message, Event) or address.startswith(">"):
            return
        if isinstance(message.fact, GoodsDelivered):
            self.delivered[message.fact.product] += message.fact.quantity
        elif isinstance(message.fact, OrderFulfilled):
            self.fulfilled[message.fact.order] += 1
            if len(self.fulfilled) == self._orders:
                self.all.set()


async def kills(factory: SimFactory, chance: Random) -> int:
    """End the gate's agent for up to three minutes, and the strategist now and then."""
    count = 0
    while factory.clock.now_s() < TROUBLE_S:
        await asyncio.sleep(chance.expovariate(1 / 60.0))
        agent = GATE if chance.random() < 0.8 else STRATEGIST
        factory.crash(agent)
        await asyncio.sleep(chance.choice((0.0, chance.uniform(0.0, 180.0))))
        factory.restart(agent)
        count += 1
    return count


@pytest.mark.parametrize("seed", variants(range(2)))
def test_every_piece_is_delivered_and_told_once(seed: int) -> None:
    async def main() -> None:
        plant, listeners = load_plant("single-track"), Listeners()
        factory = SimFactory(plant, clock(), seed=seed, listener=listeners)
        checks = Invariants(factory)
        for fault in LOSSY:
            factory.bus.begin(fault)
        orders = list(demand.orders(plant, Random(f"{seed} demand"), load=0.5, until_s=PLACED_S))
        told = Told(len(orders))
        listeners.add(checks, told)
        async with asyncio.TaskGroup() as group:
            tasks = [
                group.create_task(factory.run()),
                group.create_task(OrderClient(factory.bus, factory.clock).place(orders)),
            ]
            assert await kills(factory, Random(f"{seed} kills")) > 10
            async with asyncio.timeout_at(ENDED_S):
                await told.all.wait()
            for task in tasks:
                task.cancel()
        assert checks.broken is None
        assert told.fulfilled == {order.id: 1 for order in orders}
        wanted: Counter[str] = Counter()
        for order in orders:
            wanted.update({item.product: item.quantity for item in order.items})
        assert told.delivered == factory.floor.count().delivered == wanted

    run(main())
