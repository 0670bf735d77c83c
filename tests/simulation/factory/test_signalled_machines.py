"""Machines that are controllers with single values, in a simulated plant: a shift in which links are cut and agents are killed."""

from __future__ import annotations

import asyncio
from random import Random

import pytest

from dray.adapters.signals.signal import Sample, Signal, SignalMapping, Tag
from dray.adapters.signals.workcell import Kept, SignalledWorkcell
from dray.body import (
    Broken,
    CloseDock,
    CycleDone,
    Instruction,
    OpenDock,
    Repaired,
    Report,
    StartCycle,
    WorkcellState,
)
from dray.messages import OrderItem
from dray.plant import Plant, default_plant
from dray.plant.file.file import shipped_plant
from dray.ports import Body, Clock
from dray_sim.bodies.workcell import SimWorkcell
from dray_sim.checks.invariants import Invariants
from dray_sim.clock.loop import JUMP, clock, run
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

COUNTERS = Signal.PIECES, Signal.BAD

MODULUS = 16
"""At which its counter rolls over: within one shift, several times."""

LOOK_S = 1.0
"""How often the controller looks at what it is told."""

READY_AFTER_S = 4.0
"""What its dock takes to open."""


class Controller:
    """A machine's controller: it counts, and obeys bits, and knows nothing of materials.

    Args:
        workcell: the machine.
        plant: where it stands.
        now: the plant's clock.
    """

    def __init__(self, workcell: SimWorkcell, plant: Plant, now: Clock) -> None:
        self._workcell, self._plant, self._now = workcell, plant, now
        tags = {signal: Tag(signal.value) for signal in SIGNALS}
        for signal in COUNTERS:
            tags[signal] = Tag(signal.value, rolls_over_at=MODULUS)
        self._mapping = SignalMapping(tags, workcell.sense().stock)
        self.made = dict.fromkeys(COUNTERS, 0)
        self.body: SignalledWorkcell | None = None
        self.kept: Kept | None = None
        self.linked = True
        self._fault = False
        self._open_for, self._open_at_s = "", 0.0
        self.loads: dict[str, tuple[str, int]] = {}
        """What vehicles are to bring or take; a dock in the field needs not know."""
        workcell.attach(self._heard)
        now.call_at(now.now_s(), self._look)

    def live(self) -> Body:
        """The body of the next life of its agent."""
        spec = self._plant.machines[self._workcell.id]
        self.body = SignalledWorkcell(spec, self._plant, self._mapping, self._now, self, self.kept)
        if self.linked:
            self.link()
        return _Watched(self.body, self)

    # --- a world ---

    def remember(self, kept: Kept) -> None:
        self.kept = kept

    def write(self) -> None:
        """It looks by itself."""

    # --- what it tells ---

    def cut(self) -> None:
        """Nothing is heard of it any more."""
        self.linked = False
        if self.body is not None:
            self.body.on_link_lost("cut")

    def link(self) -> None:
        """It is heard again."""
        self.linked = True
        if self.body is not None:
            for signal in COUNTERS:
                self._tell(signal, self.made[signal] % MODULUS)
            self._tell(Signal.FAULT, self._fault)
            self._tell(Signal.DOCK_READY, bool(self._open_for))
            self.body.on_link()

    def _tell(self, signal: Signal, value: bool | int) -> None:
        if self.linked and self.body is not None:
            self.body.on_sample(signal, Sample(value))

    def _heard(self, report: Report) -> None:
        match report:
            case CycleDone(bad=bad):
                signal = Signal.BAD if bad else Signal.PIECES
                self.made[signal] += 1
                self._tell(signal, self.made[signal] % MODULUS)
            case Broken() | Repaired():
                self._fault = isinstance(report, Broken)
                self._tell(Signal.FAULT, self._fault)

    # --- what it does ---

    def _look(self) -> None:
        self._now.call_at(self._now.now_s() + LOOK_S, self._look)
        if self.body is None or not self.linked:
            return
        told = self.body.outputs
        if told[Signal.RUN] and not self._workcell.sense().cycling:
            product = str(told[Signal.PRODUCT])
            self._workcell.instruct(StartCycle(product=product))
        self._dock(str(told[Signal.DOCK_VEHICLE]) if told[Signal.DOCK_PERMIT] else "")

    def _dock(self, vehicle: str) -> None:
        if self._open_for and vehicle != self._open_for:
            self._workcell.instruct(CloseDock(vehicle=self._open_for))
            self._open_for = ""
            self._tell(Signal.DOCK_READY, False)
            return
        if not vehicle or self._open_for:
            self._open_at_s = self._now.now_s() + READY_AFTER_S
        elif self._now.now_s() >= self._open_at_s:
            item, quantity = self.loads[vehicle]
            self._workcell.instruct(OpenDock(vehicle=vehicle, item=item, quantity=quantity))
            self._open_for = vehicle
            self._tell(Signal.DOCK_READY, True)


class _Watched:
    """A body, and what it is told of loads."""

    def __init__(self, body: SignalledWorkcell, controller: Controller) -> None:
        self._body, self._controller = body, controller
        self.attach = body.attach

    def instruct(self, instruction: Instruction) -> None:
        if isinstance(instruction, OpenDock):
            self._controller.loads[instruction.vehicle] = instruction.item, instruction.quantity
        self._body.instruct(instruction)

    def sense(self) -> WorkcellState:
        return self._body.sense()


async def shift(
    plant: Plant, seed: int, span_s: float
) -> tuple[SimFactory, dict[str, Controller], Invariants]:
    """An order of each product, while links are cut and agents are killed, and then a while in peace."""
    now, listeners, chance = clock(), Listeners(), Random(seed)
    controllers: dict[str, Controller] = {}

    def embody(workcell: SimWorkcell, _life: int) -> Body:
        if workcell.id not in controllers:
            controllers[workcell.id] = Controller(workcell, plant, now)
        return controllers[workcell.id].live()

    factory = SimFactory(
        plant,
        now,
        seed=seed,
        stock_frac=(0.02, 0.15),
        listener=listeners,
        traffic=True,
        embody_machine=embody,
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
        machine = chance.choice([*controllers])
        if chance.random() < 0.5:
            factory.restart(machine)
        else:
            controllers[machine].cut()
            await asyncio.sleep(chance.uniform(1.0, 90.0))
            controllers[machine].link()
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
    for machine, controller in controllers.items():
        assert controller.kept is None or controller.kept.doubt == "", machine
        body = controller.body
        assert body is not None
        # What is reckoned is what lies there.
        assert body.sense().stock == factory.workcells[machine].sense().stock, machine
