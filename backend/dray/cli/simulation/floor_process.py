"""The process of a simulated floor: the bodies of agents with their own processes."""

from __future__ import annotations

import asyncio
import signal
from collections.abc import Callable
from typing import TYPE_CHECKING

from dray.adapters.system_clock import SystemClock
from dray.adapters.telemetry.traffic_log import TrafficLog
from dray.adapters.vda5050.link import BrokerAddress
from dray.adapters.zenoh.claim import Claim
from dray.cli.runtime.readiness import say_ready
from dray.cli.runtime.roster import FLOOR
from dray.cli.runtime.signals import stopped_by_signals
from dray.cli.runtime.surroundings import Surroundings
from dray.cli.runtime.telemetry.clock_meter import ClockMeter
from dray.cli.simulation.floor_meter import FloorMeter
from dray.errors import SettingsError, UnavailableError
from dray.messages.keys import GATE
from dray_sim.bodies.floor import NEARLY_EMPTY_FRAC, Floor
from dray_sim.remote import FloorMonitor, FloorServer
from dray_sim.vda5050.floor_fleet import speak_vda5050

if TYPE_CHECKING:
    # It needs an extra.
    from dray_sim.controllers.opcua_server import ControllerServer


async def serve_floor(
    surroundings: Surroundings,
    seed: int,
    controllers: ControllerServer | None = None,
    *,
    vda5050: BrokerAddress | None = None,
    open_gate: bool = False,
) -> None:
    """Run the simulated floor until a signal. SIGHUP cuts all connections to its OPC UA server.

    Args:
        surroundings: the process's surroundings.
        seed: determines the initial filling of buffers.
        controllers: the OPC UA server of the controllers of machines, storages and, without people there, the gate; None for ones with bodies on the bus.
        vda5050: the broker of vehicles that speak VDA 5050; None for vehicles with bodies on the bus.
        open_gate: whether the gate lets everything in, because people operate it.

    Raises:
        SettingsError: a foreign vehicle is not in the plant.
        UnavailableError: the bus is unavailable, or the plant has a floor already.
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
        floor.gate.is_open = open_gate
        controlled = (
            *(() if controllers is None else (*floor.workcells, *floor.storages)),
            *(() if vda5050 is None else floor.vehicles),
            *((GATE,) if open_gate or controllers is not None else ()),
        )
        if monitor is None:
            server = FloorServer(bus.inner, plant.id, floor, foreign=foreign, controlled=controlled)
            running = [group.create_task(server.run())]
        else:
            server = FloorServer(bus.inner, plant.id, floor, monitor.occupied, foreign, controlled)
            running = [group.create_task(server.run()), group.create_task(monitor.run())]
        if vda5050 is not None:
            running.append(group.create_task(speak_vda5050(plant, floor.vehicles, clock, vda5050)))
        end_controllers = _control(controllers, floor, clock, surroundings.settings.plant_speed)
        if controllers is not None:
            asyncio.get_running_loop().add_signal_handler(signal.SIGHUP, controllers.cut)
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
    """Give each machine and storage, and a gate without people, a controller, if there is a server for them; returns a function that ends them all."""
    if server is None:
        return lambda: None
    from dray_sim.controllers.opcua_controllers import OpcUaControllers

    controllers = OpcUaControllers(clock, server, speed)
    for workcell in floor.workcells.values():
        controllers.build_machine(workcell)
    for storage in floor.storages.values():
        controllers.build_store(storage)
    if not floor.gate.is_open:
        controllers.build_gate(floor.gate)
    return controllers.end


def _monitor(surroundings: Surroundings, floor: Floor, clock: SystemClock) -> FloorMonitor | None:
    """The monitor for two vehicles in one place; None where vehicles drive independently."""
    settings = surroundings.settings
    if not settings.traffic:
        return None
    lines = None if settings.traffic_log is None else TrafficLog(settings.traffic_log, FLOOR)
    return FloorMonitor(surroundings.plant, floor.vehicles, clock, lines)
