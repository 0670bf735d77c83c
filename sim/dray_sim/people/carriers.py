"""People who carry vehicles away, for a repair say, and put them back elsewhere; and a person who reports that wrongly.

A vehicle is switched off and lifted. After a long enough silence they report the vehicle as away. When they are done
they have a place kept for it, put it down there and switch it on. No agent should believe a careless report, about a
vehicle that is heard, or again after its return.
"""

from __future__ import annotations

import asyncio
from collections.abc import Iterable
from dataclasses import dataclass
from math import hypot
from random import Random

from dray.plant import Plant
from dray.protocol.liveness.suspicion import IDLE_INTERVAL_S, gone_s
from dray_sim.factory.sim_factory import SimFactory
from dray_sim.faults import Faults, PoweredOff
from dray_sim.people.floor_office import FloorOffice

AT_MOST = 4
"""Vehicles carried in a run."""

AWAY_S = (5.0, 240.0)

GAP_S = 60.0
"""Between two careless words, in the mean."""


@dataclass(frozen=True, slots=True)
class Carrying:
    """One vehicle that is carried.

    Attributes:
        atv: its id.
        at_s: when it is lifted (plant clock).
        away_s: how long it is away at least.
        near: where it is put back, or a node near that.
    """

    atv: str
    at_s: float
    away_s: float
    near: str


def draw_carryings(plant: Plant, random: Random, until_s: float) -> tuple[Carrying, ...]:
    """The carryings of one run by time; all begin before `until_s`, at most one for each vehicle at a time."""
    nodes = sorted(plant.stops)
    times = sorted(random.uniform(0.0, until_s) for _ in range(random.randint(1, AT_MOST)))
    return tuple(
        Carrying(random.choice(tuple(plant.fleet)), at_s, random.uniform(*AWAY_S), random.choice(nodes))
        for at_s in times
    )


class Carriers:
    """The people who carry vehicles.

    Args:
        factory: where.
        faults: a vehicle that is off is a fault, which checks must know.
        office: reports it on the bus.
    """

    def __init__(self, factory: SimFactory, faults: Faults, office: FloorOffice) -> None:
        self._factory, self._faults, self._office = factory, faults, office

    async def carry(self, carryings: Iterable[Carrying]) -> None:
        """Carry all vehicles at their times."""
        async with asyncio.TaskGroup() as group:
            for carrying in carryings:
                group.create_task(self._carry(carrying))

    async def say_carelessly(self, random: Random, until_s: float) -> None:
        """Say of vehicles that are heard that they were carried away, until then."""
        fleet = tuple(self._factory.plant.fleet)
        while True:
            await asyncio.sleep(random.expovariate(1.0 / GAP_S))
            if self._factory.clock.now_s() >= until_s:
                return
            self._office.say_carelessly(random.choice(fleet))

    async def _carry(self, carrying: Carrying) -> None:
        factory, atv = self._factory, carrying.atv
        await asyncio.sleep(carrying.at_s - factory.clock.now_s())
        if atv in factory.floor.lifted:
            return
        fault = self._faults.begin(PoweredOff(atv))
        factory.floor.lift(atv)
        back_s = factory.clock.now_s() + carrying.away_s
        # No agent believes it sooner.
        await asyncio.sleep(gone_s(IDLE_INTERVAL_S))
        self._office.carry_away(atv)
        await asyncio.sleep(max(back_s - factory.clock.now_s(), 0.0))
        while True:
            node = self._free_near(carrying.near)
            if node and await self._office.put_back(atv, node):
                break
            await asyncio.sleep(1.0)
        factory.floor.put_down(atv, node)
        self._faults.end(fault)

    def _free_near(self, node: str) -> str:
        """The nearest free place, as tablets show it; empty for none."""
        plant = self._factory.plant
        taken = {
            heard.node for heard in self._office.heard.values() if heard.atv not in self._factory.floor.lifted
        }
        for heard in self._office.heard.values():
            if heard.floor and heard.atv not in self._factory.floor.lifted:
                taken |= set(heard.floor.holds)
        here = plant.nodes[node]

        def away_m(one: str) -> float:
            return hypot(plant.nodes[one].x_m - here.x_m, plant.nodes[one].y_m - here.y_m)

        return min((stop for stop in sorted(plant.stops) if stop not in taken), key=away_m, default="")
