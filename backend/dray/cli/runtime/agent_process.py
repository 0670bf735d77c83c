"""The process of one agent: its body, its journal, its worker, an end on a signal."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager, closing

from dray.adapters.journal.sqlite_journal import SqliteJournal
from dray.adapters.zenoh.modem import Modem
from dray.body import UnplacedVehicle, VehicleState
from dray.cli.runtime.bodies.embodied import Embodied, Embody
from dray.cli.runtime.readiness import say_ready
from dray.cli.runtime.signals import asked_by_signals
from dray.cli.runtime.surroundings import Surroundings
from dray.cli.runtime.telemetry.agent_meter import AgentMeter
from dray.cli.runtime.telemetry.body_meter import BodyMeter
from dray.cli.runtime.telemetry.bus_meter import BusMeter
from dray.cli.runtime.telemetry.clock_meter import ClockMeter
from dray.cli.runtime.telemetry.traces import traced, watched
from dray.errors import UnavailableError
from dray.messages.keys import Keys
from dray.protocol.runtime.events import Agent
from dray.worker.worker import Worker

MakeAgent = Callable[[int], Agent]
"""Makes an agent for one life, from its number."""


async def run_agent(surroundings: Surroundings, name: str, make: MakeAgent, embody: Embody) -> None:
    """Run one agent until a signal: SIGTERM asks it to shut down gracefully, Ctrl-C ends it at once.

    Args:
        surroundings: the process's surroundings.
        name: its id.
        make: creates the agent.
        embody: creates its body.

    Raises:
        UnavailableError: it was started elsewhere meanwhile, its body is lost or is not the one in its
            journal, or another resource is unavailable.
        Exception: any that the agent raises.
    """
    settings, plant = surroundings.settings, surroundings.plant
    elsewhere = False

    def give_way(_agent: str) -> None:
        nonlocal elsewhere
        elsewhere = True
        worker.stop()

    async with surroundings.bus(name, give_way) as bus:
        file = settings.journal_folder / f"{name}.db"
        journal = SqliteJournal(file)
        with closing(journal), traced(settings) as tracing:
            async with embody(bus, journal) as embodied:
                body = embodied.body
                drives = body is not None and isinstance(body.sense(), VehicleState | UnplacedVehicle)
                clock = surroundings.clock()
                worker = Worker(
                    make(journal.incarnation),
                    bus=watched(settings, tracing, surroundings.time.to_wall_s)(bus),
                    clock=clock,
                    keys=Keys(plant.id),
                    # A machine has wires, whatever a computer's settings say about radio for its vehicles.
                    body=Modem(body, bus.inner, settings.bus_radio)
                    if body is not None and drives and settings.bus_radio
                    else body,
                    journal=journal,
                )
                meters = (
                    BusMeter(bus),
                    AgentMeter(worker, journal),
                    BodyMeter(embodied.failures),
                    ClockMeter(clock),
                )
                async with surroundings.told(*meters), _in_touch(embodied, worker):
                    with asked_by_signals(worker.leave, worker.stop, settings.leave_s):
                        say_ready(name)
                        await worker.run()
    if elsewhere:
        raise UnavailableError(name, "has been started elsewhere", "stop one of the two")


@asynccontextmanager
async def _in_touch(embodied: Embodied, worker: Worker) -> AsyncIterator[None]:
    """Let an agent live as long as its body does: without a body it must not send healthy heartbeats.

    Raises:
        UnavailableError: the body is silent.
        Exception: any that has ended its link.
    """
    lost = asyncio.ensure_future(embodied.lost())
    lost.add_done_callback(lambda _: worker.stop())
    try:
        yield
    finally:
        silent = not lost.cancel()
    if silent:
        lost.result()
        raise UnavailableError(
            f"the body of {worker.agent.id}",
            "has fallen silent",
            "see whether `dray floor`, or its controller, runs",
        )
