"""Runs whose machines, stores and gate are controllers: cut wires, counters that are reset, damaged memories, and what is counted in the end."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from random import Random

from msgspec.structs import replace

from dray.adapters.signals.gate import KeptSignals
from dray.adapters.signals.signal import Checked, Signal
from dray.adapters.signals.workcell import UNSURE
from dray.body import GateState, ResetFault, StorageState, WorkcellState
from dray.messages.keys import GATE
from dray.plant import Plant
from dray_sim.checks.broken import InvariantBroken
from dray_sim.controllers.gate import GateController
from dray_sim.controllers.machine import MachineController
from dray_sim.controllers.wired import Moment, Wired, WiredBodies
from dray_sim.factory.sim_factory import SimFactory
from dray_sim.faults import Crashed, Faults

CUTS = (0.5, 4.0)
"""Cut wires and reset counters in a minute."""

LONGEST_CUT_S = 60.0
"""Longest time for which a wire is cut: far beyond what counts as the absence of a controller."""

RESETS_FRAC = 0.2
"""Fraction of these events in which the counters of a controller begin at 0, while it is heard."""

GATE_FRAC = 0.3
"""Fraction of these events at the gate: it has the most to count."""

MOMENTS_FRAC = 0.4
"""Fraction of the cuts of machines and the gate that wait for the worst moment."""

WAITS_S = 120.0
"""Time for which such a cut waits for its moment at least."""

MORE_FRAC = 0.4
"""Fraction of the cuts of machines after which the controller begins one more piece before it notices."""

ASIDE_S = 180.0
"""Time after which the gate puts a container aside that is not admitted: longer than any damage, and short for a short run."""

DAMAGES = (1, 2)
"""Damaged memories in a run that has any."""

DAMAGED_FRAC = (0.1, 0.7)
"""Range of their times, as parts of the time until all wires are whole."""

DOWN_S = (1.0, 10.0)
"""Range of the time for which such an agent is down."""

UNREAD_S = (5.0, 20.0)
"""Range of the time for which it works without its memory before people come and count."""

LOOKS_S = 0.5
"""Interval between two looks whether people can count: a machine is still between two pieces for less than a second."""

VISITS_S = 20.0
"""Interval between two looks of people whether a count is in doubt."""

RESTS_S = 120.0
"""Time after the end of all work by which everything is counted: the last container has passed the gate, and levels have rested."""


@dataclass(frozen=True, slots=True)
class Cut:
    """A wire that is cut, or counters that are reset.

    Attributes:
        agent: the agent at the wire.
        at_s, until_s: when it is cut, and whole again; at one moment counters are reset.
        moment: it is cut at the first such moment in that time; None for at once.
        more: pieces that a machine begins after the cut.
    """

    agent: str
    at_s: float
    until_s: float
    moment: Moment | None = None
    more: int = 0

    @property
    def is_reset(self) -> bool:
        """Whether counters are reset."""
        return self.until_s == self.at_s

    def __str__(self) -> str:
        return (
            f"{self.at_s:7.1f} s                counters reset agent={self.agent}"
            if self.is_reset
            else f"{self.at_s:7.1f} to {self.until_s:7.1f} s  link cut {self.moment or 'at once'} agent={self.agent} more={self.more}"
        )


@dataclass(frozen=True, slots=True)
class Damage:
    """An agent that ends, and whose next life cannot read what its body has kept, until people have counted.

    Attributes:
        agent: of a machine, a store or the gate.
        at_s: when it ends, at the earliest.
        down_s: time until its next life.
        unread_s: time from then until people count.
    """

    agent: str
    at_s: float
    down_s: float
    unread_s: float

    @property
    def until_s(self) -> float:
        """When people come to count."""
        return self.at_s + self.down_s + self.unread_s

    def __str__(self) -> str:
        return f"{self.at_s:7.1f} to {self.until_s:7.1f} s  memory damaged agent={self.agent} down_s={self.down_s}"


def draw_cuts(plant: Plant, random: Random, until_s: float) -> tuple[Cut, ...]:
    """Cuts in the order of their beginnings; those of one wire do not overlap.

    Args:
        plant: its machines, stores and gate have controllers.
        random: the only source of chance.
        until_s: all wires are whole by then (plant clock).
    """
    a_second = random.uniform(*CUTS) / 60.0
    return tuple(_drawn(plant, random, until_s, a_second))


def _drawn(plant: Plant, random: Random, until_s: float, a_second: float) -> Iterator[Cut]:
    others = (*plant.machines, *plant.stores)
    moments = {GATE: Moment.PERMIT, **dict.fromkeys(plant.machines, Moment.PIECE)}
    whole_s: dict[str, float] = {}
    at_s = random.expovariate(a_second)
    while at_s < until_s:
        agent = GATE if random.random() < GATE_FRAC else random.choice(others)
        long_s = 0.0 if random.random() < RESETS_FRAC else random.uniform(0.1, LONGEST_CUT_S)
        moment = None
        if long_s and agent in moments and random.random() < MOMENTS_FRAC:
            moment = moments[agent]
            long_s += WAITS_S
        more = int(long_s > 0.0 and moments.get(agent) is Moment.PIECE and random.random() < MORE_FRAC)
        cut = Cut(agent, round(at_s, 1), round(min(at_s + long_s, until_s), 1), moment, more)
        if cut.at_s > whole_s.get(agent, 0.0):
            whole_s[agent] = cut.until_s
            yield cut
        at_s += random.expovariate(a_second)


def draw_damages(plant: Plant, random: Random, until_s: float) -> tuple[Damage, ...]:
    """Memories that are damaged, each of another agent, in the order of their times.

    Args:
        plant: its machines, stores and gate have controllers.
        random: the only source of chance.
        until_s: people have counted long before (plant clock).
    """
    agents = (GATE, random.choice(tuple(plant.machines)), random.choice(tuple(plant.stores)))
    drawn = []
    for agent in random.sample(agents, random.randint(*DAMAGES)):
        at_s = until_s * random.uniform(*DAMAGED_FRAC)
        drawn.append(
            Damage(
                agent,
                round(at_s, 1),
                round(random.uniform(*DOWN_S), 1),
                round(random.uniform(*UNREAD_S), 1),
            )
        )
    return tuple(sorted(drawn, key=lambda damage: damage.at_s))


async def play_cuts(
    cuts: tuple[Cut, ...],
    factory: SimFactory,
    bodies: WiredBodies,
    note: Callable[[str], None],
) -> None:
    """Let them happen, each at its time.

    Args:
        cuts: to happen.
        factory: where.
        bodies: their controllers.
        note: is given a line for each.
    """
    now = factory.clock

    async def happen(cut: Cut) -> None:
        await asyncio.sleep(max(0.0, cut.at_s - now.now_s()))
        wired = bodies.wired[cut.agent]
        note(f"--- {cut}")
        if cut.is_reset:
            is_heard = wired.body is not None and factory.running(cut.agent)
            if is_heard and isinstance(wired.controller, MachineController | GateController):
                wired.controller.reset_counters()
            return
        if cut.moment is None:
            wired.cut(cut.more)
        else:
            wired.cut_at(cut.moment, cut.more)
        await asyncio.sleep(cut.until_s - now.now_s())
        wired.link()

    async with asyncio.TaskGroup() as group:
        for cut in cuts:
            group.create_task(happen(cut))


async def play_damages(
    damages: tuple[Damage, ...],
    factory: SimFactory,
    bodies: WiredBodies,
    faults: Faults,
    note: Callable[[str], None],
) -> None:
    """Let them happen, each at its time; people count what lies there, as `docs/machines.md` says.

    Args:
        damages: to happen.
        factory: where.
        bodies: the controllers there.
        faults: knows of the agents that end.
        note: is given a line for each.
    """
    now = factory.clock

    async def befall(damage: Damage) -> None:
        await asyncio.sleep(max(0.0, damage.at_s - now.now_s()))
        wired = bodies.wired[damage.agent]
        # What a vehicle at the dock has brought, and not reported yet, would be counted twice.
        await _until(lambda: not wired.controller.told.get(Signal.DOCK_PERMIT))
        note(f"--- {damage}")
        wired.is_damaged = True
        fault = faults.begin(Crashed(damage.agent))
        await asyncio.sleep(damage.down_s)
        faults.end(fault)
        if damage.agent in factory.storages:
            return  # Its levels tell what lies there.
        await asyncio.sleep(damage.unread_s)
        await _until(lambda: _can_count(damage.agent, wired, factory))
        note(f"--- people have counted at {damage.agent}")
        _count(damage.agent, wired, factory)
        factory.restart(damage.agent)

    async with asyncio.TaskGroup() as group:
        for damage in damages:
            group.create_task(befall(damage))


async def _until(is_so: Callable[[], bool]) -> None:
    """Look again and again, as people do."""
    while not is_so():  # noqa: ASYNC110 - virtual time passes at once
        await asyncio.sleep(LOOKS_S)


def _can_count(agent: str, wired: Wired, factory: SimFactory) -> bool:
    """Whether the next life has begun without its memory, and nothing moves there."""
    if wired.is_damaged or wired.body is None or not wired.linked or not factory.running(agent):
        return False
    if agent in factory.workcells:
        return not (wired.controller.told[Signal.DOCK_PERMIT] or factory.workcells[agent].sense().cycling)
    return isinstance(wired.kept, KeptSignals) and wired.kept.pieces is not None


def _count(agent: str, wired: Wired, factory: SimFactory) -> None:
    """Write down what lies at a machine, or what has come in at the gate."""
    if agent in factory.workcells:
        wired.count(replace(wired.mapping, stock=factory.workcells[agent].sense().stock), None)
    elif isinstance(wired.kept, KeptSignals) and isinstance(wired.controller, GateController):
        checked = Checked(wired.kept.doubt_number, dict(wired.controller.let_in))
        wired.count(replace(wired.mapping, checked=checked), wired.kept)


async def see_to_doubts(bodies: WiredBodies) -> None:
    """Let people reset machines where a product may have been counted as another one; others stay in doubt.

    What lies there is compared in the end (`check_counts`).
    """
    while True:
        await asyncio.sleep(VISITS_S)
        for name, doubt in bodies.doubts().items():
            body = bodies.wired[name].body
            if UNSURE in doubt and body is not None:
                body.instruct(ResetFault())


def uncounted(factory: SimFactory, bodies: WiredBodies | None, place: str, item: str) -> int | None:
    """Pieces of an item that lie at a place unknown to its body; None while that cannot be told.

    That is so while the body or its controller is not heard, or a vehicle is at the dock.
    """
    wired = None if bodies is None else bodies.wired.get(place)
    if wired is None:
        return factory.uncounted(place, item)
    state = None if wired.body is None else wired.body.sense()
    if not wired.linked or not isinstance(state, WorkcellState | StorageState):
        return None
    if wired.controller.told.get(Signal.DOCK_PERMIT):
        return None
    there = factory.workcells if place in factory.workcells else factory.storages
    return there[place].sense().stock.get(item, 0) - state.stock.get(item, 0)


def check_counts(factory: SimFactory, bodies: WiredBodies, at_s: float) -> None:
    """Compare what controllers' bodies have counted with what lies there.

    Raises:
        InvariantBroken: a piece was counted twice or never, or a count is in doubt.
    """
    for name, doubt in bodies.doubts().items():
        raise InvariantBroken(2, at_s, f"the count of {name} is in doubt: {doubt}")
    for name, wired in bodies.wired.items():
        state = None if wired.body is None else wired.body.sense()
        if isinstance(state, GateState):
            counted = state.arrived
            real = {goal: bodies.arrived(goal) for goal in {*counted, *factory.gate.sense().arrived}}
        elif isinstance(state, WorkcellState | StorageState):
            there = factory.workcells if name in factory.workcells else factory.storages
            counted, real = state.stock, there[name].sense().stock
        else:
            continue
        for key in sorted({*counted, *real}):
            here, lies = counted.get(key, 0), real.get(key, 0)
            if here != lies:
                raise InvariantBroken(2, at_s, f"{name} has counted {here} of {key}, and {lies} are there")
