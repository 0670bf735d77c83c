"""Orders between a gateway and a strategist that both end and begin again: none is lost, none is made twice."""

from __future__ import annotations

import asyncio
from collections import Counter
from random import Random

import pytest

from dray.gateway.live.timescale import TimeScale
from dray.gateway.orders.outbox import Outbox
from dray.memory import WHOLE
from dray.messages import CancellationTaken, Event, Message, OrderTaken
from dray.messages.fact import OrderDropped, OrderFulfilled
from dray.messages.keys import STRATEGIST
from dray.plant import default_plant
from dray.store.orders.orders import Item, Order
from dray.store.orders.progress import OrderStatus
from dray_sim.checks.invariants import Invariants
from dray_sim.clock.loop import VirtualClock, clock, run
from dray_sim.factory.sim_factory import SimFactory
from dray_sim.network.listeners import Listeners
from dray_sim.people import demand

ORDERS_S = 1800.0
"""In this time orders are placed and cancelled."""

TROUBLE_S = 2400.0
"""In this time gateways and strategists end."""

SPAN_S = 9000.0
"""By then every order is delivered."""

LOSS_FRAC = 0.2


class Ended:
    """Counts how orders ended."""

    def __init__(self) -> None:
        self.fulfilled: Counter[str] = Counter()
        self.dropped: Counter[str] = Counter()

    def on_message(self, _at_s: float, _sender: str, _address: str, message: Message) -> None:
        if isinstance(message, Event) and isinstance(message.fact, OrderFulfilled):
            self.fulfilled[message.fact.order] += 1
        elif isinstance(message, Event) and isinstance(message.fact, OrderDropped):
            self.dropped[message.fact.order] += 1


class OrderPeer:
    """A gateway with its database, as far as orders go: it has never heard what became of any.

    So every life of it sends everything again, and hears only four of five answers.
    """

    def __init__(self, factory: SimFactory, chance: Random) -> None:
        self._factory, self._chance = factory, chance
        self._outbox: Outbox | None = None
        self.orders: dict[str, Order] = {}
        self.cancelled: dict[str, None] = {}
        self.fulfilled: set[str] = set()
        """By the strategist's word."""

    def place(self, order: demand.Order) -> None:
        self.orders[order.id] = placed = Order(
            id=order.id,
            status=OrderStatus.RELEASED,
            releases=1,
            customer="Customer",
            token=order.id,
            items=tuple(Item(item.product, item.quantity) for item in order.items),
            created_at_s=order.at_s,
            due_at_s=order.due_s,
        )
        if self._outbox is not None:
            self._outbox.release(placed)

    def cancel(self, order: str) -> None:
        self.cancelled[order] = None
        if self._outbox is not None:
            self._outbox.cancel(order)

    async def live(self, for_s: float) -> None:
        """One life of the gateway."""
        plant_clock: VirtualClock = self._factory.clock
        session = self._factory.bus.join("gateway", self._on_message)

        def send(to: str, message: Message) -> None:
            if self._chance.random() >= LOSS_FRAC:
                session.send(to, message)

        self._outbox = Outbox(
            send=send,
            time=TimeScale(0.0, 0.0, 1.0),
            wall_s=plant_clock.now_s,
            products=self._factory.plant.products,
        )
        repeating = asyncio.create_task(self._outbox.run())
        for order in self.cancelled:
            self._outbox.cancel(order)
        self._outbox.ask(order for order in self.orders.values() if order.id not in self.cancelled)
        await asyncio.sleep(for_s)
        repeating.cancel()
        session.leave()
        self._outbox = None

    def _on_message(self, sender: str, message: Message) -> None:
        assert self._outbox is not None
        assert sender == STRATEGIST
        if self._chance.random() < LOSS_FRAC:
            return
        assert isinstance(message, OrderTaken | CancellationTaken)
        self._outbox.answered(message)
        if isinstance(message, OrderTaken) and message.fulfilled:
            self.fulfilled.add(message.order)


async def gateways(peer: OrderPeer, chance: Random) -> None:
    while clock().now_s() < TROUBLE_S:
        await peer.live(chance.uniform(0.0, 120.0))
        await asyncio.sleep(chance.choice((0.0, chance.uniform(0.0, 60.0))))
    await peer.live(SPAN_S - clock().now_s())


async def strategists(factory: SimFactory, chance: Random) -> None:
    while clock().now_s() < TROUBLE_S:
        await asyncio.sleep(chance.uniform(0.0, 120.0))
        factory.crash(STRATEGIST)
        await asyncio.sleep(chance.choice((0.0, chance.uniform(0.0, 60.0))))
        factory.restart(STRATEGIST)


async def customers(peer: OrderPeer, chance: Random) -> None:
    plant = default_plant()
    async with asyncio.TaskGroup() as group:
        for order in demand.orders(plant, chance, load=0.8, until_s=ORDERS_S):
            await asyncio.sleep(max(0.0, order.at_s - clock().now_s()))
            peer.place(order)
            if chance.random() < 0.2:
                group.create_task(cancel_later(peer, order.id, chance.expovariate(1 / 60.0)))


async def cancel_later(peer: OrderPeer, order: str, wait_s: float) -> None:
    await asyncio.sleep(wait_s)
    peer.cancel(order)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(1, 4))])
def test_every_order_is_delivered_once_or_dropped(seed: int) -> None:
    async def main() -> None:
        listeners, ended = Listeners(), Ended()
        factory = SimFactory(default_plant(), clock(), seed=seed, listener=listeners)
        checks = Invariants(factory)
        listeners.add(checks, ended)
        peer = OrderPeer(factory, Random(f"{seed} loss"))
        life = asyncio.create_task(factory.run())
        async with asyncio.TaskGroup() as group:
            group.create_task(gateways(peer, Random(f"{seed} gateways")))
            group.create_task(strategists(factory, Random(f"{seed} strategists")))
            group.create_task(customers(peer, Random(f"{seed} customers")))
        assert not life.done()
        life.cancel()
        assert checks.broken is None
        wanted = {order for order in peer.orders if order not in peer.cancelled}
        assert wanted
        assert {order: ended.fulfilled[order] for order in wanted} == dict.fromkeys(wanted, 1)
        assert not wanted & ended.dropped.keys()
        assert peer.fulfilled
        assert all(ended.fulfilled[order] == 1 for order in peer.fulfilled)
        # A cancelled order may have been delivered before; never both, and neither when it never came.
        assert all(ended.fulfilled[order] + ended.dropped[order] <= 1 for order in peer.cancelled)
        assert [goal for goal in goals_held(factory) if goal in peer.cancelled] == []

    run(main())


def goals_held(factory: SimFactory) -> list[str]:
    """The orders that machines still work at, one by one."""
    held = [factory.journals[machine].memory.get(WHOLE) for machine in factory.workcells]
    return [goal.work.order for note in held for goal in getattr(note, "goals", ())]
