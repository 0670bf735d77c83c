"""Machines whose bodies are people, in a simulated plant: what they say counts once, though agents are killed and tablets are away."""

from __future__ import annotations

import asyncio
from collections import deque
from random import Random

import pytest
from msgspec import UNSET

from dray.adapters.people.workcell import Kept, PeopleWorkcell
from dray.body import (
    CloseDock,
    CycleDone,
    Instruction,
    OpenDock,
    Report,
    StartCycle,
    WorkcellState,
)
from dray.messages import (
    CommandAnswered,
    CommandRefusal,
    MachineCommand,
    MachineCommandKind,
    MachineHeartbeat,
    Message,
    OrderItem,
    UnconfirmedLoad,
)
from dray.messages.keys import Keys
from dray.plant import default_plant
from dray.ports import Body, Clock
from dray_sim.bodies.workcell import SimWorkcell
from dray_sim.checks.invariants import Invariants
from dray_sim.clock.loop import JUMP, clock, run
from dray_sim.factory.installation import Bodies
from dray_sim.factory.sim_factory import SimFactory
from dray_sim.network.listeners import Listeners
from dray_sim.people.demand import Order
from dray_sim.people.order_client import OrderClient

PLANT = default_plant()
PIECES = 12
KIND = MachineCommandKind

ANSWER_S = 3.0
"""After so long a word is said again."""


class Workplace:
    """A machine that people work: it obeys its agent, and what comes of it only people tell.

    Args:
        workcell: the machine.
        now: the plant's clock.

    Attributes:
        finished: pieces of which nobody has told yet.
        kept: what is on the disk of its agent.
    """

    def __init__(self, workcell: SimWorkcell, now: Clock) -> None:
        self.workcell, self._now = workcell, now
        self.finished: deque[CycleDone] = deque()
        self.kept = Kept(workcell.sense().stock, made_s=now.now_s())
        workcell.attach(self._see)

    def live(self) -> Body:
        """The body of the next life of its agent."""
        self.body = PeopleWorkcell(PLANT.machines[self.workcell.id], PLANT, self._now, self, self.kept)
        return _Worked(self.body, self)

    def remember(self, kept: Kept) -> None:
        self.kept = kept

    def _see(self, report: Report) -> None:
        if isinstance(report, CycleDone):
            self.finished.append(report)


class _Worked:
    """A body, and the machine that people work as it says."""

    def __init__(self, body: PeopleWorkcell, place: Workplace) -> None:
        self._body, self._workcell = body, place.workcell
        self.attach = body.attach

    def instruct(self, instruction: Instruction) -> None:
        self._body.instruct(instruction)
        begun = isinstance(instruction, StartCycle) and self._body.sense().cycling == instruction.product
        if isinstance(instruction, OpenDock | CloseDock) or (begun and not self._workcell.sense().cycling):
            self._workcell.instruct(instruction)

    def sense(self) -> WorkcellState:
        return self._body.sense()


class People:
    """Who work at all machines, with a tablet that is away at times and says each word more often than once."""

    def __init__(self, factory: SimFactory, places: dict[str, Workplace], chance: Random) -> None:
        self._factory, self._places, self._chance = factory, places, chance
        self._session = factory.bus.join("tablet", self._hear)
        self._session.subscribe(Keys(PLANT.id).all_machine_heartbeats)
        self._answers: dict[str, asyncio.Future[CommandAnswered]] = {}
        self._loads: dict[str, tuple[UnconfirmedLoad, ...]] = {}
        self.confirmed = 0

    async def work(self, machine: str) -> None:
        """Tell what happens at one machine."""
        while True:
            await asyncio.sleep(self._chance.uniform(1.0, 8.0))
            if self._chance.random() < 0.02:
                await asyncio.sleep(self._chance.uniform(30.0, 240.0))
            place = self._places.get(machine)
            while place is not None and place.finished:
                piece = place.finished[0]
                kind = KIND.SCRAPPED if piece.bad else KIND.MADE
                assert await self.say(machine, kind, 1, piece.product) is None
                place.finished.popleft()
            for load in self._loads.pop(machine, ()):
                kind = KIND.TAKEN if load.goes else KIND.ARRIVED
                refused = await self.say(machine, kind, load.quantity, load.item, load.vehicle)
                # Its heartbeat may have told of one that is confirmed since.
                assert refused in (None, CommandRefusal.NO_LOAD)
                self.confirmed += refused is None

    async def say(
        self, machine: str, kind: MachineCommandKind, quantity: int, item: str, vehicle: str = ""
    ) -> CommandRefusal | None:
        """Say a word until it is answered, and once more."""
        name = f"w{len(self._answers)}"
        answer = self._answers[name] = asyncio.get_running_loop().create_future()
        command = MachineCommand(
            command=name, kind=kind, item=item, quantity=quantity, vehicle=vehicle, sure=True
        )
        while not answer.done():
            self._send(machine, command)
            await asyncio.wait((answer,), timeout=ANSWER_S)
        self._send(machine, command)
        return answer.result().reason

    def _send(self, machine: str, command: MachineCommand) -> None:
        until_s = self._factory.clock.now_s() + 2 * ANSWER_S
        grant = self._factory.authority.grant
        self._session.send(
            machine, grant(machine, command, person="maria", areas=None, valid_until_s=until_s)
        )

    def _hear(self, _sender: str, message: Message) -> None:
        if isinstance(message, CommandAnswered) and not self._answers[message.command].done():
            self._answers[message.command].set_result(message)
        elif isinstance(message, MachineHeartbeat) and message.people is not UNSET:
            self._loads[message.machine] = message.people.loads


class Workplaces(Bodies):
    """People stand between each workcell and its machine's agent."""

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self.places: dict[str, Workplace] = {}

    def embody_machine(self, workcell: SimWorkcell, _life: int) -> Body:
        if workcell.id not in self.places:
            self.places[workcell.id] = Workplace(workcell, self._clock)
        return self.places[workcell.id].live()


async def shift(seed: int, span_s: float) -> tuple[SimFactory, dict[str, Workplace], Invariants, People]:
    """An order of each product, while agents are killed, and then a while in peace."""
    now, listeners, chance = clock(), Listeners(), Random(seed)
    bodies = Workplaces(now)
    places = bodies.places
    factory = SimFactory(
        PLANT,
        now,
        seed=seed,
        stock_frac=(0.02, 0.15),
        listener=listeners,
        traffic=True,
        bodies=bodies,
    )
    invariants = Invariants(factory)
    listeners.add(invariants)
    people = People(factory, places, Random(seed))
    orders = [Order(f"o-{item}", 0.0, 7200.0, (OrderItem(item, PIECES),)) for item in PLANT.products]
    running = [asyncio.create_task(factory.run())]
    running.append(asyncio.create_task(OrderClient(factory.bus, now).place(orders)))
    running += [asyncio.create_task(people.work(machine)) for machine in PLANT.machines]
    while now.now_s() < span_s / 2:
        await asyncio.sleep(chance.uniform(20.0, 120.0))
        factory.restart(chance.choice([*places]))
    await asyncio.sleep(span_s / 2)
    for task in running:
        assert not task.done() or task.exception() is None, task
        task.cancel()
    await asyncio.gather(*running, return_exceptions=True)
    return factory, places, invariants, people


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2])
def test_every_word_counts_once_and_every_order_is_delivered(seed: int) -> None:
    factory, places, invariants, people = run(shift(seed, 9000.0), JUMP)
    assert invariants.broken is None
    arrived = sum(sum(warehouse.arrived.values()) for warehouse in factory.delivery.values())
    assert arrived == PIECES * len(PLANT.products)
    assert people.confirmed >= 10
    for machine, place in places.items():
        # What people have said is what lies there.
        assert place.body.sense().stock == place.workcell.sense().stock, machine
