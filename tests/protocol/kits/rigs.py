"""Rigs that run one agent as a plain function, with a body of paper.

A rig stands for the worker and for the world. It keeps the time, wakes its agent when the agent wants to
be woken, and keeps everything that the agent wants done until a test asks for it. Nothing moves by itself:
a test says when a vehicle has arrived, a cycle has ended, an answer has come.
"""

from __future__ import annotations

from typing import Any

import plentiful
from credulous import believing
from defaults import PLANT
from effects import T, award_number, instructed, published, sent
from msgspec import UNSET
from seals import trusts_seals
from spoken import accepted, bid
from vehicle_states import standing

from dray.body import (
    ActionDone,
    ActionFailed,
    Admit,
    BodyState,
    Charge,
    CycleDone,
    Drive,
    Drop,
    GateState,
    GoodsArrived,
    NodePassed,
    OpenDock,
    Pick,
    Report,
    StartCycle,
    StockChanged,
    VehicleState,
    WayDone,
    WorkcellState,
)
from dray.memory import Memory
from dray.messages import (
    NOTHING_KNOWN,
    Accepted,
    Award,
    BufferLevel,
    Confirmed,
    MachineHeartbeat,
    Message,
    Production,
    Role,
    UnconfirmedLoad,
)
from dray.messages.heartbeat_stock import with_stock
from dray.plant import Plant
from dray.protocol.machine.machine import Machine
from dray.protocol.runtime.events import (
    Agent,
    Effect,
    Event,
    Leave,
    Leaving,
    Received,
    Reported,
    Send,
    Started,
    Woke,
)
from dray.protocol.strategist.strategist import Strategist
from dray.protocol.vehicle.atv import Atv

WAKES_PER_INSTANT = 100
"""More than any agent has alarms: one that wants to be woken more often without time passing spins."""


class Rig:
    """One agent, its time, and everything it wanted done."""

    def __init__(self, agent: Agent) -> None:
        self.agent = agent
        self.now_s = 0.0
        self.all: list[Effect] = []
        """Every effect from the beginning."""
        self.memory: Memory = {}
        """What an earlier life has committed."""
        self.stations_answer = True
        """Storages have what is to be fetched, and say so at once."""

    def sense(self) -> BodyState | None:
        """What the agent's body would tell of itself now."""
        return None

    def handle(self, event: Event) -> list[Effect]:
        """Let one thing happen; what the agent wants done about it."""
        effects = self.agent.handle(event, self.now_s)
        self.all += effects
        return effects

    def heard_by_stations(self, effects: list[Effect]) -> list[Effect]:
        """Let the stations of storages answer at once, unless the test answers for them."""
        for effect in list(effects) if self.stations_answer else ():
            said = plentiful.answer(effect.to, effect.message) if isinstance(effect, Send) else None
            if isinstance(effect, Send) and said is not None:
                effects += self.on_message(effect.to, said)
        return effects

    def start(self) -> list[Effect]:
        return self.handle(Started(self.sense(), self.memory))

    def on_message(self, sender: str, message: Message) -> list[Effect]:
        return self.handle(Received(sender, message))

    def report(self, report: Report) -> list[Effect]:
        return self.handle(Reported(report))

    def wake(self) -> list[Effect]:
        return self.handle(Woke(self.sense()))

    def run(self, until_s: float) -> list[Effect]:
        """Let time pass, waking the agent whenever it wants to be woken."""
        effects: list[Effect] = []
        wakes = 0
        while self.agent.wake_at_s <= until_s:
            at_s = max(self.now_s, self.agent.wake_at_s)
            wakes = wakes + 1 if at_s == self.now_s else 0
            assert wakes < WAKES_PER_INSTANT, f"{self.agent.id} spins at {at_s} s"
            self.now_s = at_s
            effects += self.wake()
        self.now_s = max(self.now_s, until_s)
        return effects

    def leave(self) -> list[Effect]:
        """It is asked to leave."""
        return self.handle(Leaving())

    @property
    def has_left(self) -> bool:
        return any(isinstance(effect, Leave) for effect in self.all)

    def heartbeats(self, kind: type[T]) -> list[T]:
        """All heartbeats so far."""
        return published(self.all, kind)


class VehicleRig(Rig):
    """A vehicle that stands where it was put until the test lets it arrive."""

    def __init__(
        self,
        atv: str = "ATV1",
        *,
        kind: str = "light",
        node: str = "p3",
        battery_frac: float = 0.9,
        plant: Plant = PLANT,
        **options: Any,
    ) -> None:
        super().__init__(Atv(atv, plant, vehicle_type=kind, trusts=trusts_seals, **options))
        self.node = node
        self.battery_frac = battery_frac
        self.load = ("", 0)
        self.held = False
        self.problem, self.about = "", NOTHING_KNOWN

    def handle(self, event: Event) -> list[Effect]:
        effects = super().handle(event)
        return self.heard_by_stations(effects)

    def sense(self) -> VehicleState:
        return standing(
            PLANT,
            self.node,
            battery_frac=self.battery_frac,
            load=self.load[0],
            load_quantity=self.load[1],
            held=self.held,
            problem=self.problem,
            about_problem=self.about,
        )

    def last(self, kind: type[T]) -> T:
        """The newest instruction of a kind."""
        return instructed(self.all, kind)[-1]

    def arrive(self) -> list[Effect]:
        """The newest way is driven to its end."""
        way = self.last(Drive)
        self.node = way.nodes[-1]
        index = len(way.nodes) - 1
        passed = NodePassed(order=way.order, node=self.node, index=index, battery_frac=self.battery_frac)
        return self.report(passed) + self.report(WayDone(order=way.order, node=self.node))

    def picked(self) -> list[Effect]:
        """The newest pick has ended well."""
        pick = self.last(Pick)
        self.load = (pick.item, pick.quantity)
        return self.report(ActionDone(order=pick.order))

    def dropped(self) -> list[Effect]:
        """The newest drop has ended well."""
        self.load = ("", 0)
        return self.report(ActionDone(order=self.last(Drop).order))

    def charged(self) -> list[Effect]:
        """The newest charge has filled the battery."""
        self.battery_frac = 1.0
        return self.report(ActionDone(order=self.last(Charge).order))

    def failed(self, kind: type[Drive | Pick | Drop | Charge], reason: str = "no") -> list[Effect]:
        """The newest instruction of a kind was refused or failed."""
        return self.report(ActionFailed(order=self.last(kind).order, reason=reason))


class MachineRig(Rig):
    """A machine with its workcell: cycles take material at once and end when the test says so.

    It believes its bidders and its carriers, unless it is told to doubt them: prices are plain numbers then,
    and a load is down when its carrier says so. Storages have what it needs, unless the test answers for them.
    """

    def __init__(
        self,
        machine: str = "M7",
        stock: dict[str, int] | None = None,
        *,
        doubts: bool = False,
        stations_answer: bool = True,
        plant: Plant = PLANT,
        **options: Any,
    ) -> None:
        agent = Machine(machine, plant, **{"trusts": trusts_seals, **options})
        super().__init__(agent if doubts else believing(agent))
        self.stations_answer = stations_answer
        self.stock = dict.fromkeys(plant.materials_of(machine), 0) | dict(stock or {})
        self.broken, self.about = "", NOTHING_KNOWN
        self.paces = True
        self.answers = False
        self.people = False
        self.loads: tuple[UnconfirmedLoad, ...] = ()
        self.opened: tuple[str, ...] = ()
        self.let_in: OpenDock | None = None
        self.seq = 0
        self._cycles = 0

    counts = True
    """Whether its body counts what vehicles bring and take."""

    def reported_stock(self) -> tuple[tuple[BufferLevel, ...], tuple[BufferLevel, ...]]:
        """Materials and finished products, as its heartbeats have told them so far."""
        told: MachineHeartbeat | None = None
        for heartbeat in self.heartbeats(MachineHeartbeat):
            told = with_stock(heartbeat, told)
        assert told is not None
        assert told.buffers is not UNSET
        assert told.goods is not UNSET
        return told.buffers, told.goods

    def sense(self) -> WorkcellState:
        return WorkcellState(
            stock=dict(self.stock),
            seq=self.seq,
            cycling=self.cycling,
            broken=self.broken,
            about_problem=self.about,
            paces=self.paces,
            answers=self.answers,
            counts=self.counts,
            people=self.people,
            loads=self.loads,
            opened=self.opened,
            let_in=self.let_in,
        )

    def handle(self, event: Event) -> list[Effect]:
        effects = super().handle(event)
        for cycle in instructed(effects, StartCycle):
            for line in cycle.bill:
                self.stock[line.material] -= line.quantity
                assert self.stock[line.material] >= 0, f"a cycle took {line.material} that is not there"
        return self.heard_by_stations(effects)

    def award_goal(self, goal: str, work: Production, deadline_s: float = 3600.0) -> list[Effect]:
        """The strategist awards a goal."""
        message = Award(task=goal, epoch=1, role=Role.PRIMARY, work=work, deadline_s=deadline_s)
        return self.on_message("STRATEGIST", message)

    def confirm_goal(self, goal: str) -> list[Effect]:
        """The strategist has heard that a goal was accepted."""
        return self.on_message("STRATEGIST", Confirmed(task=goal, epoch=1))

    def take_goal(self, goal: str, work: Production, deadline_s: float = 3600.0) -> list[Effect]:
        """The strategist awards a goal, and confirms it when the machine accepts."""
        effects = self.award_goal(goal, work, deadline_s)
        return effects + self.confirm_goal(goal) if sent(effects, Accepted) else effects

    def cycle(self) -> list[Effect]:
        """The running cycle ends."""
        product = instructed(self.all, StartCycle)[-1].product
        self._cycles += 1
        started = len(instructed(self.all, StartCycle))
        assert self._cycles <= started, "no cycle runs"
        self.stock[product] = self.stock.get(product, 0) + 1
        self.seq += 1
        return self.report(CycleDone(product=product, seq=self.seq))

    def cycles(self, count: int) -> list[Effect]:
        """The running cycle ends, and the ones that follow it."""
        return [effect for _ in range(count) for effect in self.cycle()]

    @property
    def is_cycling(self) -> bool:
        return len(instructed(self.all, StartCycle)) > self._cycles

    @property
    def cycling(self) -> str:
        """The product of the running cycle, as the workcell senses it."""
        return instructed(self.all, StartCycle)[-1].product if self.is_cycling else ""

    def stocked(self, item: str, change: int, vehicle: str = "") -> list[Effect]:
        """Something is put in, or taken out."""
        self.stock[item] = self.stock.get(item, 0) + change
        self.seq += 1
        return self.report(StockChanged(item=item, change=change, seq=self.seq, vehicle=vehicle))

    def hire(self, task: str, atv: str, *, cost_s: float = 50.0) -> list[Effect]:
        """A vehicle bids alone for a task that is announced now, is asked, and accepts."""
        effects = self.on_message(atv, bid(cost_s, task=task))
        while not sent(effects, Award, to=atv):
            effects += self.run(self.agent.wake_at_s)
        return effects + self.on_message(atv, accepted(task, number=award_number(effects, atv, task)))


class BlindRig(MachineRig):
    """A machine whose body does not count what vehicles bring and take."""

    counts = False


class StrategistRig(Rig):
    """A strategist with its gate, which answers when the test says so."""

    def __init__(self, *, memory: Memory | None = None, plant: Plant = PLANT, **options: Any) -> None:
        super().__init__(Strategist(plant, **options))
        self.memory = memory or {}
        self.arrived: dict[str, int] = {}

    def sense(self) -> GateState:
        return GateState(arrived=dict(self.arrived))

    def admitted(self, goal: str) -> int:
        """How many pieces of a goal the gate was told to let in; -1 for a goal it never heard of."""
        told = [admit.quantity for admit in instructed(self.all, Admit) if admit.goal == goal]
        return told[-1] if told else -1

    def arrive(self, goal: str, pieces: int) -> list[Effect]:
        """The gate lets pieces in, and says how many there are."""
        self.arrived[goal] = self.arrived.get(goal, 0) + pieces
        return self.gate_answers(goal)

    def gate_answers(self, goal: str) -> list[Effect]:
        """The gate says how many pieces of a goal are in."""
        arrived = GoodsArrived(goal=goal, arrived=self.arrived.get(goal, 0), admitted=self.admitted(goal))
        return self.report(arrived)
