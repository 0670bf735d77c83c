"""The process of one agent: its body, its journal, its worker, an end on a signal."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager, closing

from dray.adapters.journal.sqlite_journal import SqliteJournal
from dray.adapters.remote_body import BodySpec, RemoteBody, put_down
from dray.adapters.zenoh.modem import Modem
from dray.body import VehicleState
from dray.cli.runtime.readiness import say_ready
from dray.cli.runtime.serving import asked_by_signals
from dray.cli.runtime.surroundings import Surroundings
from dray.cli.runtime.telemetry.agent_meter import AgentMeter
from dray.cli.runtime.telemetry.bus_meter import BusMeter
from dray.cli.runtime.telemetry.clock_meter import ClockMeter
from dray.cli.runtime.telemetry.traces import traced, watched
from dray.errors import UnavailableError
from dray.messages.keys import Keys
from dray.protocol.runtime.events import Agent
from dray.worker.worker import Worker

MakeAgent = Callable[[int], Agent]
"""Makes an agent for one life, from its number."""


async def run_agent(
    surroundings: Surroundings, name: str, make: MakeAgent, added: BodySpec | None = None
) -> None:
    """Run one agent until a signal: SIGTERM asks it to shut down gracefully, Ctrl-C ends it at once.

    Args:
        surroundings: what it begins with.
        name: its id.
        make: makes it.
        added: its body, when the plant file of the floor does not know it.

    Raises:
        UnavailableError: it has been started elsewhere meanwhile, its body is lost or is not the one that its
            journal is about, or something else that it needs is not there.
        whatever the agent raises.
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
            if added is not None:
                await put_down(bus.inner, plant.id, added)
            body = RemoteBody(bus.inner, plant.id, name, journal.incarnation)
            await body.connect()
            if body.is_new and journal.memory:
                remedy = "move away the journals of all agents whose bodies are on that floor"
                raise UnavailableError(
                    f"the body that {file} is about", "is gone, for the floor has begun anew", remedy
                )
            drives = isinstance(body.sense(), VehicleState)
            clock = surroundings.clock()
            worker = Worker(
                make(journal.incarnation),
                bus=watched(settings, tracing, surroundings.time.to_wall_s)(bus),
                clock=clock,
                keys=Keys(plant.id),
                # A machine has wires, whatever a computer's settings name for its vehicles.
                body=Modem(body, bus.inner, settings.bus_radio) if drives and settings.bus_radio else body,
                journal=journal,
            )
            meters = BusMeter(bus), AgentMeter(worker, journal), ClockMeter(clock)
            async with surroundings.told(*meters), _in_touch(body, worker):
                with asked_by_signals(worker.leave, worker.stop, settings.leave_s):
                    say_ready(name)
                    await worker.run()
    if elsewhere:
        raise UnavailableError(name, "has been started elsewhere", "stop one of the two")


@asynccontextmanager
async def _in_touch(body: RemoteBody, worker: Worker) -> AsyncIterator[None]:
    """Let an agent live as long as its body does: without one it must not say that all is well.

    Raises:
        UnavailableError: nothing was heard of the body any more.
    """
    lost = asyncio.create_task(body.lost())
    lost.add_done_callback(lambda _: worker.stop())
    try:
        yield
    finally:
        silent = not lost.cancel()
    if silent:
        raise UnavailableError(
            f"the body of {worker.agent.id}", "has fallen silent", "see whether `dray floor` runs"
        )
