"""What the processes of a plant have in common: logs, the bus, the plant's clock, an end on a signal."""

from __future__ import annotations

import asyncio
import sys
from collections.abc import AsyncIterator, Callable, Iterable
from contextlib import asynccontextmanager, closing
from dataclasses import dataclass

import typer
from prometheus_client import Metric
from prometheus_client.registry import Collector

from dray.adapters.metrics_port import metrics_port, new_registry
from dray.adapters.sqlite_journal import SqliteJournal
from dray.adapters.system_clock import SystemClock
from dray.adapters.zenoh_access import Apart
from dray.adapters.zenoh_bus import ZenohBus
from dray.adapters.zenoh_claim import Claim
from dray.adapters.zenoh_exclusions import Exclusions
from dray.adapters.zenoh_links import Identity, Links
from dray.adapters.zenoh_modem import Modem
from dray.body import VehicleState
from dray.cli.logs import prepare_logs
from dray.cli.meters.agent import AgentMeter
from dray.cli.meters.bus import BusMeter
from dray.cli.meters.clock import ClockMeter
from dray.cli.meters.floor import FloorMeter
from dray.cli.readiness import tell_ready
from dray.cli.serving import asked_by_signals, stopped_by_signals
from dray.cli.traces import traced, watched
from dray.errors import UnavailableError
from dray.gateway.timescale import TimeScale
from dray.messages.keys import Keys
from dray.plant import Plant, default_plant, load_plant
from dray.protocol.runtime.events import Agent
from dray.protocol.strategist.strategist import STRATEGIST
from dray.settings import Settings
from dray.store.historian import AGENT as HISTORIAN
from dray.worker import Worker
from dray_sim.floor import NEARLY_EMPTY_FRAC, Floor
from dray_sim.remote import FloorServer, Newcomer, RemoteBody, put_down

READY = "{name} is ready"
"""What a process says when it takes part, on a line of its own."""


@dataclass(frozen=True, slots=True)
class Surroundings:
    """What a process of a plant begins with.

    Attributes:
        settings: of the process.
        plant: what stands where.
    """

    settings: Settings
    plant: Plant

    @classmethod
    def of(cls, settings: Settings) -> Surroundings:
        """Read the plant and prepare the log.

        Raises:
            PlantError: the plant file cannot be used.
        """
        prepare_logs(settings)
        plant = default_plant() if settings.plant_file is None else load_plant(settings.plant_file)
        return cls(settings, plant)

    def clock(self) -> SystemClock:
        """The plant's clock, on the running loop."""
        speed, epoch_s = self.settings.plant_speed, self.settings.plant_epoch_s
        return SystemClock(asyncio.get_running_loop(), speed=speed, epoch_s=epoch_s)

    @property
    def time(self) -> TimeScale:
        """The plant's clock and the wall's."""
        epoch_s = self.settings.plant_epoch_s
        return TimeScale(epoch_s, epoch_s, self.settings.plant_speed)

    @asynccontextmanager
    async def bus(
        self, name: str, replaced: Callable[[str], None] = lambda _: None
    ) -> AsyncIterator[ZenohBus]:
        """The bus, as long as the context lasts.

        Args:
            name: of the certificate; the agent's.
            replaced: see `ZenohBus`.

        Raises:
            SettingsError: no certificates, and plain links were not asked for.
            UnavailableError: an address cannot be listened on.
        """
        bus = ZenohBus(links_of(self.settings, self.plant, name), self.plant.id, replaced)
        exclusions = Exclusions(bus, self.settings.journal_folder / f"{name}.shut-out")
        try:
            yield bus
        finally:
            exclusions.end()
            bus.close()

    @asynccontextmanager
    async def told(self, *meters: Collector) -> AsyncIterator[None]:
        """The metrics of the process, told to Prometheus as long as the context lasts, if that is asked for.

        Args:
            meters: of what is in this process.

        Raises:
            UnavailableError: the address for it cannot be listened on.
        """
        if not self.settings.metrics_listen:
            yield
            return
        registry = new_registry()
        for meter in meters:
            registry.register(meter)

        async def read() -> Iterable[Metric]:
            return registry.collect()

        async with metrics_port(self.settings.metrics_listen, read):
            yield


def links_of(settings: Settings, plant: Plant, name: str) -> Links:
    """The links that the settings ask for, with the certificate of this name.

    Raises:
        SettingsError: its files are not there.
    """
    folder = settings.bus_certificates
    wired = (*plant.machines, *plant.storages, STRATEGIST, HISTORIAN, settings.gateway_name)
    # A vehicle may be linked over another one, and everybody's words come to it that way.
    apart = settings.bus_apart and name in wired
    return Links(
        listen=settings.bus_listen,
        peers=settings.bus_peers,
        multicast=settings.bus_multicast,
        identity=None if folder is None else Identity.in_folder(folder, name),
        plain=settings.bus_plain,
        lease_s=settings.bus_lease_s,
        apart=Apart(plant.id, tuple(plant.fleet), wired) if apart else None,
    )


MakeAgent = Callable[[int], Agent]
"""Makes an agent for one life, from its number."""


async def run_agent(
    surroundings: Surroundings, name: str, make: MakeAgent, newcomer: Newcomer | None = None
) -> None:
    """Run one agent until a signal: SIGTERM asks it to leave in order, Ctrl-C ends it at once.

    Args:
        surroundings: what it begins with.
        name: its id.
        make: makes it.
        newcomer: its body, when the plant file of the floor does not know it.

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
            if newcomer is not None:
                await put_down(bus.inner, plant.id, newcomer)
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


FLOOR = "floor"
"""The name of the simulated floor's process, and of its certificate."""


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


def say_ready(name: str) -> None:
    """Tell whoever has started this process that it takes part."""
    typer.echo(READY.format(name=name))
    # A pipe would hold the line back.
    sys.stdout.flush()
    tell_ready()
