"""One whole simulated factory: bodies, network and one worker per agent, from a plant and a seed.

Everything is built here and nothing starts by itself: `run` starts it, and ends with it.
"""

from __future__ import annotations

import asyncio
from collections.abc import Mapping
from random import Random
from typing import Protocol

from dray import __version__
from dray.messages import Message
from dray.messages.keys import Keys
from dray.plant import Plant
from dray.protocol.atv import Atv
from dray.protocol.events import Agent
from dray.protocol.machine import Machine
from dray.protocol.strategist import Strategist
from dray.worker import Worker
from dray_sim.chargers import Chargers
from dray_sim.loop import VirtualClock
from dray_sim.network import WLAN, Latency, SimNetwork
from dray_sim.stores import DeliveryWarehouse, Place, SourceWarehouse, Storage
from dray_sim.vehicle import SimVehicle
from dray_sim.workcell import SimWorkcell

FIRST_STOCK_FRAC = (0.4, 1.0)
"""Buffers at the start of a run: a shift begins where the one before it ended."""


class Ear(Protocol):
    """Whoever wants to know all that is said."""

    def hear(self, at_s: float, sender: str, address: str, message: Message) -> None: ...


class Ears:
    """Several listeners in one, asked in the order in which they were added."""

    def __init__(self) -> None:
        self._ears: tuple[Ear, ...] = ()

    def add(self, *ears: Ear) -> None:
        self._ears += ears

    def hear(self, at_s: float, sender: str, address: str, message: Message) -> None:
        for ear in self._ears:
            ear.hear(at_s, sender, address, message)


class SimFactory:
    """A factory that is ready to run.

    Args:
        plant: what stands where.
        clock: the virtual clock of the loop that it will run on.
        seed: everything that is left to chance follows from it.
        incarnation: how often this factory was started; names tasks and goals apart.
        stock_frac: how full buffers are at the start, from and to, of what they hold.
        latency: of the network.
        codec: pass every message through the wire format.
        ear: hears everything that is said.

    Attributes:
        bus: join it to take part.
        vehicles, workcells, storages: the bodies and places by id.
        workers: by agent id.
    """

    def __init__(
        self,
        plant: Plant,
        clock: VirtualClock,
        *,
        seed: int,
        incarnation: int = 1,
        stock_frac: tuple[float, float] = FIRST_STOCK_FRAC,
        latency: Latency = WLAN,
        codec: bool = False,
        ear: Ear | None = None,
    ) -> None:
        self.plant = plant
        self.clock = clock
        self.keys = Keys(plant.id)
        # One generator per concern, so that a change to one does not shift the chances of another.
        self.bus = SimNetwork(clock, Random(f"{seed} network"), latency, codec=codec, trace=ear)
        self.source = SourceWarehouse(plant.source_warehouses[0], plant.materials)
        self.delivery: Mapping[str, DeliveryWarehouse] = {
            warehouse: DeliveryWarehouse(warehouse, plant.products) for warehouse in plant.delivery_warehouses
        }
        self.storages: Mapping[str, Storage] = {
            spec.id: Storage(spec, clock, self.source) for spec in plant.storages.values()
        }
        stock = Random(f"{seed} stock")
        self.workcells: Mapping[str, SimWorkcell] = {
            spec.id: SimWorkcell(spec, plant, clock, stock=_first_stock(plant, spec.id, stock_frac, stock))
            for spec in plant.machines.values()
        }
        places: dict[str, Place] = {**self.storages, **self.workcells, **self.delivery}
        chargers = Chargers()
        self.vehicles: Mapping[str, SimVehicle] = {
            spec.id: SimVehicle(spec, plant.vehicle_types[spec.type], plant, clock, places, chargers)
            for spec in plant.fleet.values()
        }
        self.workers: dict[str, Worker] = {}
        for machine, workcell in self.workcells.items():
            agent = Machine(machine, plant, incarnation=incarnation, software=__version__)
            self._add(agent, workcell)
        for atv, vehicle in self.vehicles.items():
            self._add(Atv(atv, plant, incarnation=incarnation, software=__version__), vehicle)
        self._add(Strategist(plant, incarnation=incarnation), None)

    async def run(self) -> None:
        """Run all agents until cancelled.

        Raises:
            ExceptionGroup: an agent ended by an exception (invariant 8).
        """
        async with asyncio.TaskGroup() as group:
            for worker in self.workers.values():
                group.create_task(worker.run(), name=worker.agent.id)

    def _add(self, agent: Agent, body: SimVehicle | SimWorkcell | None) -> None:
        self.workers[agent.id] = Worker(agent, bus=self.bus, clock=self.clock, keys=self.keys, body=body)


def _first_stock(plant: Plant, machine: str, frac: tuple[float, float], random: Random) -> dict[str, int]:
    return {
        material: round(plant.materials[material].buffer * random.uniform(*frac))
        for material in plant.materials_of(machine)
    }
