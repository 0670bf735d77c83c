"""A crowd for the benchmarks of the panels: many vehicles that drive about, and the messages of their agents.

They neither negotiate nor wait. Their messages have the shape and the rate of a plant in which all vehicles work: a
heartbeat per vehicle and per machine each second.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from itertools import count
from math import ceil
from random import Random

from dray.messages import (
    AtvHeartbeat,
    AtvStatus,
    Brief,
    Event,
    MachineHeartbeat,
    MachineStatus,
    Message,
    Phase,
    Pose,
    Role,
    Transport,
)
from dray.messages.fact import AnyFact, AwardAnswered, PhaseEntered, TaskOpened
from dray.messages.heartbeat import BufferLevel, GoalBrief
from dray.plant import Plant
from dray.plant.model import MachineSpec
from dray.plant.roads import DirectedLane
from dray_sim.plants.generator import generate_plant

PERIOD_S = 1.0
"""Period of the heartbeats of an agent at work."""

SPEED_MPS = 1.5
"""A light carrier's, on every lane: the more moves, the harder the work."""

AHEAD = 8
"""Nodes of a planned way: some 60 m, as of a transport half across a hall."""

MACHINES_PER_VEHICLE = 0.4

GROUP = 3
"""Vehicles in a group: one carries and is watched, one watches it, one drives without a task."""

LOT = 8
"""Pieces of each transport."""

LONGEST_S = 3_600.0
"""Due times lie so far ahead that no benchmark comes to them."""


class Driver:
    """A vehicle that drives from node to node without an end.

    Args:
        plant: where.
        name: the vehicle.
        phase_s: when its first heartbeat is due.
        chance: which way it takes.
    """

    def __init__(self, plant: Plant, name: str, phase_s: float, chance: Random) -> None:
        self._plant, self._name, self._chance = plant, name, chance
        self._at_s = 0.0
        self._driven_m = chance.random()
        start = plant.fleet[name].node
        self._way: deque[DirectedLane] = deque([chance.choice(plant.roads.leaving[start])])
        self._plan()
        self.due_s = phase_s

    def heartbeat(self, seq: int, task: Brief | None, watches: tuple[Brief, ...]) -> AtvHeartbeat:
        """Its heartbeat when it is due; the next one is due a period later."""
        self._drive((self.due_s - self._at_s) * SPEED_MPS)
        self._at_s = self.due_s
        self.due_s += PERIOD_S
        lane = self._way[0]
        a, b = self._plant.nodes[lane.start], self._plant.nodes[lane.end]
        part = self._driven_m / lane.length_m
        return AtvHeartbeat(
            atv=self._name,
            incarnation=1,
            seq=seq,
            at_s=self._at_s,
            status=AtvStatus.WORKING,
            pose=Pose(a.x_m + (b.x_m - a.x_m) * part, a.y_m + (b.y_m - a.y_m) * part, lane.heading_rad),
            node=lane.start,
            speed_mps=SPEED_MPS,
            battery_frac=0.6,
            load="" if task is None else task.item,
            load_quantity=0 if task is None else task.quantity,
            task=task,
            watches=watches,
            way=tuple(each.end for each in self._way),
        )

    def _drive(self, metres: float) -> None:
        self._driven_m += metres
        while self._driven_m >= self._way[0].length_m:
            self._driven_m -= self._way.popleft().length_m
            self._plan()

    def _plan(self) -> None:
        while len(self._way) < AHEAD:
            last = self._way[-1]
            ways = self._plant.roads.leaving[last.end]
            # Back only where nothing else is left.
            onward = [lane for lane in ways if lane.end != last.start] or ways
            self._way.append(self._chance.choice(onward))


class Crowd:
    """All of them.

    Args:
        vehicles: how many.
        seed: of the plant, and of the ways.

    Attributes:
        plant: where they drive, made for so many.
    """

    def __init__(self, vehicles: int, seed: int = 1) -> None:
        self.plant = generate_plant(seed, max(1, ceil(vehicles * MACHINES_PER_VEHICLE)), vehicles)
        chance = Random(seed)
        self._drivers = [
            Driver(self.plant, name, number / vehicles * PERIOD_S, chance)
            for number, name in enumerate(self.plant.fleet)
        ]
        self._names = list(self.plant.fleet)
        self._machines = list(self.plant.machines.values())
        self._item = self.plant.file.materials[0].id
        self._machines_due_s = 0.0
        self._seq = count(1)

    def transports(self) -> Iterator[Message]:
        """The messages of the transports under way: one transport for every group of vehicles."""
        numbers: dict[str, int] = {}
        for group in range(len(self._names) // GROUP):
            for agent, fact in self._transport(group):
                numbers[agent] = numbers.get(agent, 0) + 1
                yield Event(agent=agent, incarnation=1, number=numbers[agent], at_s=0.0, fact=fact)

    def until(self, now_s: float) -> Iterator[Message]:
        """The heartbeats that are due up to this moment of the plant's clock, and were not told before."""
        for number, driver in enumerate(self._drivers):
            while driver.due_s <= now_s:
                yield driver.heartbeat(next(self._seq), *self._briefs(number))
        while self._machines_due_s <= now_s:
            yield from map(self._machine, self._machines)
            self._machines_due_s += PERIOD_S

    def _briefs(self, number: int) -> tuple[Brief | None, tuple[Brief, ...]]:
        group, place = divmod(number, GROUP)
        if place == GROUP - 1 or (group + 1) * GROUP > len(self._names):
            return None, ()
        role = Role.PRIMARY if place == 0 else Role.SECONDARY
        phase = Phase.CARRYING if place == 0 else None
        brief = Brief(f"T-{group}", 1, role, self._coordinator(group).id, phase, self._item, LOT, LONGEST_S)
        return (brief, ()) if place == 0 else (None, (brief,))

    def _machine(self, machine: MachineSpec) -> MachineHeartbeat:
        product = machine.makes[0].product
        pieces = int(self._machines_due_s / machine.makes[0].cycle_s)
        bill = self.plant.products[product].bill
        return MachineHeartbeat(
            machine=machine.id,
            incarnation=1,
            seq=next(self._seq),
            at_s=self._machines_due_s,
            status=MachineStatus.PRODUCING,
            product=product,
            goals=(GoalBrief(f"G-{machine.id}", product, 10_000, pieces, 0),),
            buffers=tuple(BufferLevel(line.material, 40 - pieces % 40, 60, 20, 0) for line in bill),
            goods=(BufferLevel(product, pieces % 8, 8),),
        )

    def _coordinator(self, group: int) -> MachineSpec:
        return self._machines[group % len(self._machines)]

    def _transport(self, group: int) -> Iterator[tuple[str, AnyFact]]:
        machine, task = self._coordinator(group).id, f"T-{group}"
        storage = next(iter(self.plant.storages))
        work = Transport(self._item, LOT, (storage,), machine, "tote")
        primary, secondary, _ = self._names[group * GROUP : (group + 1) * GROUP]
        yield machine, TaskOpened(task, 1, Role.PRIMARY, 1, work, 40.0, LONGEST_S, 1.0)
        for role, name in ((Role.PRIMARY, primary), (Role.SECONDARY, secondary)):
            yield machine, AwardAnswered(task, 1, role, name, "accepted")
        yield primary, PhaseEntered(task, 1, Phase.CARRYING)
