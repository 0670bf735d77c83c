"""Runs whose machines, stores and gate are controllers: cut wires, counters that are reset, and what is counted in the end."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from random import Random

from dray.body import GateState, StorageState, WorkcellState
from dray.messages.keys import GATE
from dray.plant import Plant
from dray_sim.checks.broken import InvariantBroken
from dray_sim.controllers.gate import GateController
from dray_sim.controllers.machine import MachineController
from dray_sim.controllers.wired import WiredBodies
from dray_sim.factory.sim_factory import SimFactory

CUTS = (0.5, 4.0)
"""Cut wires and reset counters in a minute."""

LONGEST_CUT_S = 60.0
"""Longest time for which a wire is cut: far beyond what counts as the absence of a controller."""

RESETS_FRAC = 0.2
"""Fraction of these events in which the counters of a controller begin at 0, while it is heard."""

GATE_FRAC = 0.3
"""Fraction of these events at the gate: it has the most to count."""

RESTS_S = 120.0
"""Time after the end of all work by which everything is counted: the last container has passed the gate, and levels have rested."""


@dataclass(frozen=True, slots=True)
class Cut:
    """A wire that is cut, or counters that are reset.

    Attributes:
        agent: the agent at the wire.
        at_s, until_s: when it is cut, and whole again; at one moment counters are reset.
    """

    agent: str
    at_s: float
    until_s: float

    @property
    def is_reset(self) -> bool:
        """Whether counters are reset."""
        return self.until_s == self.at_s

    def __str__(self) -> str:
        return (
            f"{self.at_s:7.1f} s                counters reset agent={self.agent}"
            if self.is_reset
            else f"{self.at_s:7.1f} to {self.until_s:7.1f} s  link cut agent={self.agent}"
        )


def draw_cuts(plant: Plant, random: Random, until_s: float) -> tuple[Cut, ...]:
    """Cuts in the order of their beginnings; those of one wire do not overlap.

    Args:
        plant: its machines, stores and gate have controllers.
        random: the only source of chance.
        until_s: all wires are whole by then (plant clock).
    """
    others = (*plant.machines, *plant.stores)
    a_second = random.uniform(*CUTS) / 60.0
    return tuple(_drawn(others, random, until_s, a_second))


def _drawn(others: tuple[str, ...], random: Random, until_s: float, a_second: float) -> Iterator[Cut]:
    whole_s: dict[str, float] = {}
    at_s = random.expovariate(a_second)
    while at_s < until_s:
        agent = GATE if random.random() < GATE_FRAC else random.choice(others)
        long_s = 0.0 if random.random() < RESETS_FRAC else random.uniform(0.1, LONGEST_CUT_S)
        end_s = min(at_s + long_s, until_s)
        if at_s > whole_s.get(agent, 0.0):
            whole_s[agent] = end_s
            yield Cut(agent, round(at_s, 1), round(end_s, 1))
        at_s += random.expovariate(a_second)


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
            if isinstance(wired.controller, MachineController | GateController):
                wired.controller.reset_counters()
            return
        wired.cut()
        await asyncio.sleep(cut.until_s - now.now_s())
        wired.link()

    async with asyncio.TaskGroup() as group:
        for cut in cuts:
            group.create_task(happen(cut))


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
