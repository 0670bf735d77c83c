"""The process of a simulated floor: the bodies of agents that are processes of their own."""

from __future__ import annotations

import asyncio

from dray.adapters.zenoh.claim import Claim
from dray.cli.runtime.readiness import say_ready
from dray.cli.runtime.roster import FLOOR
from dray.cli.runtime.serving import stopped_by_signals
from dray.cli.runtime.surroundings import Surroundings
from dray.cli.runtime.telemetry.clock_meter import ClockMeter
from dray.cli.simulation.floor_meter import FloorMeter
from dray.errors import UnavailableError
from dray_sim.bodies.floor import NEARLY_EMPTY_FRAC, Floor
from dray_sim.remote import FloorServer


async def serve_floor(surroundings: Surroundings, seed: int) -> None:
    """Run the simulated floor until a signal.

    Raises:
        UnavailableError: the bus is not to be had, or the plant has a floor already, whose bodies are at work.
    """
    stopped = asyncio.Event()
    second = False
    plant = surroundings.plant

    def give_way() -> None:
        nonlocal second
        second = True
        stopped.set()

    async with surroundings.bus(FLOOR) as bus, asyncio.TaskGroup() as group:
        claim = Claim(bus, FLOOR, give_way)
        clock = surroundings.clock()
        floor = Floor(plant, clock, seed=seed, stock_frac=NEARLY_EMPTY_FRAC)
        server = FloorServer(bus.inner, plant.id, floor)
        telling = group.create_task(server.run())
        async with surroundings.told(FloorMeter(server), ClockMeter(clock)):
            with stopped_by_signals(stopped.set):
                say_ready(FLOOR)
                await stopped.wait()
        telling.cancel()
        server.end()
        claim.end()
    if second:
        raise UnavailableError(f"the floor of {plant.id}", "runs elsewhere already", "end that one first")
