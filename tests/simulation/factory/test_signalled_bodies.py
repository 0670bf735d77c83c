"""Machines, storages and a gate that are controllers with single values, in a simulated plant: a shift in which links are cut and agents are killed."""

from __future__ import annotations

import asyncio
from random import Random

import pytest

from dray.adapters.signals.gate import KeptSignals, SignalledGate
from dray.adapters.signals.workcell import Kept
from dray.messages import OrderItem
from dray.messages.keys import GATE
from dray.plant import Plant, default_plant
from dray.plant.file.file import shipped_plant
from dray.ports import Body
from dray_sim.checks.invariants import Invariants
from dray_sim.clock.loop import JUMP, clock, run
from dray_sim.controllers.gate import GateController
from dray_sim.controllers.wired import Wired, WiredBodies
from dray_sim.factory.sim_factory import SimFactory
from dray_sim.network.listeners import Listeners
from dray_sim.people.demand import Order
from dray_sim.people.order_client import OrderClient

PLANT = default_plant()
LEVELS = shipped_plant("levels")
"""Machines that make parts for others."""
PIECES = 12

MODULUS = 16
"""At which its counter rolls over: within one shift, several times."""


async def shift(plant: Plant, seed: int, span_s: float) -> tuple[SimFactory, dict[str, Wired], Invariants]:
    """An order of each product, while links are cut and agents are killed, and then a while in peace."""
    now, listeners, chance = clock(), Listeners(), Random(seed)
    bodies = WiredBodies(plant, now, modulus=MODULUS)
    factory = SimFactory(
        plant,
        now,
        seed=seed,
        stock_frac=(0.02, 0.15),
        listener=listeners,
        traffic=True,
        bodies=bodies,
    )
    controllers = bodies.wired
    invariants = Invariants(factory)
    listeners.add(invariants)
    orders = [
        Order(f"o-{item}", 0.0, 7200.0, (OrderItem(item, PIECES),))
        for item in plant.products
        if item not in plant.parts
    ]
    running = [asyncio.create_task(factory.run())]
    running.append(asyncio.create_task(OrderClient(factory.bus, now).place(orders)))
    while now.now_s() < span_s / 2:
        await asyncio.sleep(chance.uniform(20.0, 120.0))
        name = chance.choice([*controllers, *[GATE] * len(controllers)])
        if chance.random() < 0.5:
            factory.restart(name)
        else:
            controllers[name].cut()
            await asyncio.sleep(chance.uniform(1.0, 90.0))
            controllers[name].link()
    await asyncio.sleep(span_s / 2)
    for task in running:
        assert not task.done() or task.exception() is None, task
        task.cancel()
    await asyncio.gather(*running, return_exceptions=True)
    return factory, controllers, invariants


@pytest.mark.slow
@pytest.mark.parametrize(
    ("plant", "seed"),
    [(PLANT, 1), (PLANT, 2), (LEVELS, 1)],
    ids=["default 1", "default 2", "parts from machine to machine 1"],
)
def test_every_piece_is_counted_once_and_every_order_is_delivered(plant: Plant, seed: int) -> None:
    factory, controllers, invariants = run(shift(plant, seed, 7200.0), JUMP)
    assert invariants.broken is None
    arrived = sum(sum(warehouse.arrived.values()) for warehouse in factory.delivery.values())
    assert arrived == PIECES * sum(item not in plant.parts for item in plant.products)
    there: dict[str, Body] = {**factory.workcells, **factory.storages}
    for name, wired in controllers.items():
        assert not isinstance(wired.kept, Kept | KeptSignals) or wired.kept.doubt == "", name
        assert wired.body is not None
        if isinstance(wired.body, SignalledGate):
            assert wired.body.sense().arrived == factory.gate.sense().arrived
            assert isinstance(wired.controller, GateController)
            assert not wired.controller.aside
            continue
        # What is reckoned is what lies there.
        assert wired.body.sense().stock == there[name].sense().stock, name
