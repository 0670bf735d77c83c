"""The process of a simulated floor: the bodies of agents that are processes of their own."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import TYPE_CHECKING

from dray.adapters.system_clock import SystemClock
from dray.adapters.telemetry.traffic_log import TrafficLog
from dray.adapters.zenoh.claim import Claim
from dray.cli.runtime.readiness import say_ready
from dray.cli.runtime.roster import FLOOR
from dray.cli.runtime.signals import stopped_by_signals
from dray.cli.runtime.surroundings import Surroundings
from dray.cli.runtime.telemetry.clock_meter import ClockMeter
from dray.cli.simulation.floor_meter import FloorMeter
from dray.errors import SettingsError, UnavailableError
from dray_sim.bodies.floor import NEARLY_EMPTY_FRAC, Floor
from dray_sim.remote import FloorMonitor, FloorServer

if TYPE_CHECKING:
    # It needs an extra.
    from dray_sim.controllers.opcua_server import ControllerServer


async def serve_floor(
    surroundings: Surroundings, seed: int, controllers: ControllerServer | None = None
) -> None:
    """Run the simulated floor until a signal.

    Args:
        surroundings: of the process.
        seed: how full buffers are at the start follows from it.
        controllers: by whose nodes machines speak with their agents; None for machines whose bodies agents use over the bus.

    Raises:
        SettingsError: a foreign vehicle is none of the plant's.
        UnavailableError: the bus is not to be had, or the plant has a floor already, whose bodies are at work.
    """
    stopped = asyncio.Event()
    second = False
    plant, foreign = surroundings.plant, surroundings.settings.foreign
    if unknown := [atv for atv in foreign if atv not in plant.fleet]:
        raise SettingsError("DRAY_FOREIGN", f"the plant has no vehicle {', '.join(unknown)}")

    def give_way() -> None:
        nonlocal second
        second = True
        stopped.set()

    async with surroundings.bus(FLOOR) as bus, asyncio.TaskGroup() as group:
        claim = Claim(bus, FLOOR, give_way)
        clock = surroundings.clock()
        floor = Floor(plant, clock, seed=seed, stock_frac=NEARLY_EMPTY_FRAC)
        monitor = _monitor(surroundings, floor, clock)
        controlled = () if controllers is None else tuple(floor.workcells)
        if monitor is None:
            server = FloorServer(bus.inner, plant.id, floor, foreign=foreign, controlled=controlled)
            running = [group.create_task(server.run())]
        else:
            server = FloorServer(bus.inner, plant.id, floor, monitor.occupied, foreign, controlled)
            running = [group.create_task(server.run()), group.create_task(monitor.run())]
        end_controllers = _control(controllers, floor, clock, surroundings.settings.plant_speed)
        async with surroundings.told(FloorMeter(server, monitor), ClockMeter(clock)):
            with stopped_by_signals(stopped.set):
                say_ready(FLOOR)
                await stopped.wait()
        for each in running:
            each.cancel()
        if monitor is not None:
            monitor.look()
        end_controllers()
        server.end()
        claim.end()
    if second:
        raise UnavailableError(f"the floor of {plant.id}", "runs elsewhere already", "end that one first")


def _control(
    server: ControllerServer | None, floor: Floor, clock: SystemClock, speed: float
) -> Callable[[], None]:
    """Give each machine a controller, where there is a server for them; returns what ends them all."""
    if server is None:
        return lambda: None
    from dray_sim.controllers.opcua_controllers import OpcUaControllers

    controllers = OpcUaControllers(clock, server, speed)
    for workcell in floor.workcells.values():
        controllers.build(workcell)
    return controllers.end


def _monitor(surroundings: Surroundings, floor: Floor, clock: SystemClock) -> FloorMonitor | None:
    """Who sees whether two vehicles are in one spot; nobody where they drive as if each were alone."""
    settings = surroundings.settings
    if not settings.traffic:
        return None
    lines = None if settings.traffic_log is None else TrafficLog(settings.traffic_log, FLOOR)
    return FloorMonitor(surroundings.plant, floor.vehicles, clock, lines)
