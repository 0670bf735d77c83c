"""Machines, storages and a gate that are controllers with single values, in a simulated plant: a shift in which links are cut and agents are killed."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from random import Random
from typing import Any

import pytest

from dray.adapters.signals.gate import KeptSignals, SignalledGate
from dray.adapters.signals.signal import (
    AT_A_DOCK,
    LEVEL,
    OF_A_GATE,
    Sample,
    Signal,
    SignalMapping,
    Tag,
    Value,
)
from dray.adapters.signals.store import KeptStore, SignalledStore
from dray.adapters.signals.workcell import Kept, SignalledWorkcell
from dray.messages import OrderItem
from dray.messages.keys import GATE
from dray.plant import Plant, default_plant
from dray.plant.file.file import shipped_plant
from dray.ports import Body, Clock
from dray_sim.bodies.gate import Gate
from dray_sim.bodies.stores import Storage
from dray_sim.bodies.workcell import SimWorkcell
from dray_sim.checks.invariants import Invariants
from dray_sim.clock.loop import JUMP, clock, run
from dray_sim.controllers.gate import GateController
from dray_sim.controllers.machine import COUNTERS, MachineController
from dray_sim.controllers.store import StoreController
from dray_sim.factory.sim_factory import SimFactory
from dray_sim.network.listeners import Listeners
from dray_sim.people.demand import Order
from dray_sim.people.order_client import OrderClient

PLANT = default_plant()
LEVELS = shipped_plant("levels")
"""Machines that make parts for others."""
PIECES = 12

SIGNALS = (
    *(Signal.PIECES, Signal.BAD, Signal.FAULT, Signal.DOCK_READY),
    *(Signal.RUN, Signal.PRODUCT, Signal.DOCK_PERMIT, Signal.DOCK_VEHICLE),
)

MODULUS = 16
"""At which its counter rolls over: within one shift, several times."""


class Wired:
    """The controller of a machine, a storage or the gate, wired to the body of each life of its agent; the wire may be cut.

    Args:
        make: the body of the next life, of its world and of what the last life has kept.
    """

    def __init__(
        self, make: Callable[[Wired, Any], SignalledWorkcell | SignalledStore | SignalledGate]
    ) -> None:
        self._make = make
        self.controller: MachineController | StoreController | GateController
        self.body: SignalledWorkcell | SignalledStore | SignalledGate | None = None
        self.kept: Kept | KeptStore | KeptSignals | None = None
        self.linked = True

    def live(self) -> Body:
        """The body of the next life of its agent."""
        self.body = self._make(self, self.kept)
        if self.linked:
            self.link()
        return self.body

    # --- a world ---

    def remember(self, kept: Kept | KeptStore | KeptSignals) -> None:
        self.kept = kept

    def write(self) -> None:
        if self.linked and self.body is not None:
            for name, value in self.body.outputs.items():
                self.controller.on_write(Signal(name), value)

    # --- the wire ---

    def cut(self) -> None:
        """Nothing is heard of it any more, and it hears nothing."""
        self.linked = False
        if self.body is not None:
            self.body.on_link_lost("cut")

    def link(self) -> None:
        """It is heard again."""
        self.linked = True
        if self.body is not None:
            for signal, value in self.controller.shows.items():
                self.tell(signal, value)
            self.body.on_link()
            self.write()

    def tell(self, name: str, value: Value) -> None:
        """It shows a value."""
        if (
            self.linked
            and self.body is not None
            and (name in (*SIGNALS, Signal.GOAL) or name.startswith(LEVEL))
        ):
            self.body.on_sample(name, Sample(value))


def wired_machine(workcell: SimWorkcell, plant: Plant, now: Clock) -> Wired:
    """A machine whose counters roll over within the shift, several times."""
    tags = {signal: Tag(signal.value) for signal in SIGNALS}
    for signal in COUNTERS:
        tags[signal] = Tag(signal.value, rolls_over_at=MODULUS)
    mapping, spec = SignalMapping(tags, workcell.sense().stock), plant.machines[workcell.id]
    wired = Wired(lambda world, kept: SignalledWorkcell(spec, plant, mapping, now, world, kept))
    wired.controller = MachineController(workcell, now, wired.tell, modulus=MODULUS)
    return wired


def wired_store(storage: Storage, plant: Plant, now: Clock) -> Wired:
    """A storage with a scale for each material."""
    tags = {signal: Tag(signal.value) for signal in AT_A_DOCK}
    levels = {item: Tag(item) for item in storage.stock}
    mapping, spec = SignalMapping(tags, dict(storage.stock), levels), plant.stores[storage.id]
    wired = Wired(lambda world, kept: SignalledStore(spec, mapping, now, world, kept))
    wired.controller = StoreController(storage, now, wired.tell)
    return wired


def wired_gate(gate: Gate, now: Clock) -> Wired:
    """A gate with a reader of labels, and a counter."""
    tags = {signal: Tag(signal.value) for signal in (Signal.PIECES, *OF_A_GATE)}
    mapping = SignalMapping(tags)
    wired = Wired(lambda world, kept: SignalledGate(mapping, now, world, kept))
    wired.controller = GateController(gate, now, wired.tell)
    return wired


async def shift(plant: Plant, seed: int, span_s: float) -> tuple[SimFactory, dict[str, Wired], Invariants]:
    """An order of each product, while links are cut and agents are killed, and then a while in peace."""
    now, listeners, chance = clock(), Listeners(), Random(seed)
    controllers: dict[str, Wired] = {}

    def embody_machine(workcell: SimWorkcell, _life: int) -> Body:
        if workcell.id not in controllers:
            controllers[workcell.id] = wired_machine(workcell, plant, now)
        return controllers[workcell.id].live()

    def embody_store(storage: Storage, _life: int) -> Body:
        if storage.id not in controllers:
            controllers[storage.id] = wired_store(storage, plant, now)
        return controllers[storage.id].live()

    def embody_gate(gate: Gate, _life: int) -> Body:
        if GATE not in controllers:
            controllers[GATE] = wired_gate(gate, now)
        return controllers[GATE].live()

    factory = SimFactory(
        plant,
        now,
        seed=seed,
        stock_frac=(0.02, 0.15),
        listener=listeners,
        traffic=True,
        embody_machine=embody_machine,
        embody_store=embody_store,
        embody_gate=embody_gate,
    )
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
