"""The vehicles' side: a process of its own that ends when its stdin does."""

from __future__ import annotations

import asyncio
import contextlib
import sys

from dray.adapters.system_clock import SystemClock
from dray.adapters.vda5050.link import BrokerAddress
from dray.plant import Plant, load_plant
from dray.plant.model import VehicleSpec
from dray_sim.bodies.floor import Floor
from dray_sim.vda5050.on_broker import VehicleOnBroker, words_of

PLANT = "large"
MANUFACTURER = "Bench"

SPEED = 10.0
"""Rate of the vehicles' clock: a lane takes less than a second, so that many can be measured."""

STATES_HZ = 10.0
"""States per real second of each vehicle."""


def chosen(plant: Plant, count: int) -> tuple[VehicleSpec, ...]:
    """The vehicles that are measured: the first of the fleet."""
    return tuple(plant.fleet.values())[:count]


async def run(port: int, count: int) -> None:
    """Speak and listen until stdin ends."""
    plant = load_plant(PLANT)
    clock = SystemClock(asyncio.get_running_loop(), speed=SPEED)
    floor = Floor(plant, clock, seed=1)
    broker = BrokerAddress("127.0.0.1", port, tls=False)
    vehicles = [
        VehicleOnBroker(
            floor.vehicles[spec.id],
            plant.vehicle_types[spec.type],
            plant,
            clock,
            broker,
            words_of("3.0", MANUFACTURER, spec.id, plant.id),
        )
        for spec in chosen(plant, count)
    ]
    tasks = [asyncio.create_task(vehicle.run()) for vehicle in vehicles]
    ended = asyncio.get_running_loop().run_in_executor(None, sys.stdin.read)
    while not ended.done():
        for vehicle in vehicles:
            if vehicle.vehicle is not None:
                vehicle.vehicle.say_state()
        await asyncio.sleep(1.0 / STATES_HZ)
    for task in tasks:
        task.cancel()
    await asyncio.gather(*tasks, return_exceptions=True)


def main() -> None:
    """Run with the port of the broker and the number of vehicles as arguments."""
    with contextlib.suppress(KeyboardInterrupt):
        asyncio.run(run(int(sys.argv[1]), int(sys.argv[2])))
