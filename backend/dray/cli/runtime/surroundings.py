"""The surroundings of a process of a plant: its settings, the plant, the plant's clock, a connection to the bus, its metrics."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable, Iterable
from contextlib import asynccontextmanager
from dataclasses import dataclass

from prometheus_client import Metric
from prometheus_client.registry import Collector

from dray.adapters.security.identity import Identity
from dray.adapters.security.signing import is_signed
from dray.adapters.system_clock import SystemClock
from dray.adapters.telemetry.metrics_port import metrics_port, new_registry
from dray.adapters.zenoh.access import Apart
from dray.adapters.zenoh.bus import ZenohBus
from dray.adapters.zenoh.exclusions import Exclusions
from dray.adapters.zenoh.links import Links
from dray.cli.runtime.telemetry.logs import prepare_logs
from dray.gateway.live.timescale import TimeScale
from dray.messages.keys import GATE, HISTORIAN, strategists_of
from dray.plant import Plant, default_plant, load_plant
from dray.protocol.traffic.traffic_map import TrafficMap
from dray.settings import Settings


@dataclass(frozen=True, slots=True)
class Surroundings:
    """The surroundings of a process of a plant.

    Attributes:
        settings: the process's settings.
        plant: the plant file's content.
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

    @property
    def traffic(self) -> TrafficMap | None:
        """The map for right of way; None where vehicles drive without.

        It is of the common plant file: places and districts must be the same for a joining machine.
        """
        return TrafficMap(self.plant, is_signed) if self.settings.traffic else None

    @property
    def strategists(self) -> tuple[str, ...]:
        """The ids of all strategists of the plant."""
        return strategists_of(self.settings.strategists)

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
            name: the certificate's name, which is the agent's.
            replaced: see `ZenohBus`.

        Raises:
            SettingsError: there are no certificates, and plain links were not requested.
            UnavailableError: listening on an address failed.
        """
        links = links_of(self.settings, self.plant, name)
        bus = ZenohBus(links, self.plant.id, replaced, self.settings.plant_speed)
        exclusions = Exclusions(bus, self.settings.journal_folder / f"{name}.shut-out")
        try:
            yield bus
        finally:
            exclusions.end()
            bus.close()

    @asynccontextmanager
    async def told(self, *meters: Collector) -> AsyncIterator[None]:
        """Serve the process's metrics to Prometheus as long as the context lasts, if the settings ask for it.

        Args:
            meters: meters of this process's parts.

        Raises:
            UnavailableError: listening on its address failed.
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
    """The links by the settings, with the certificate of this name.

    Raises:
        SettingsError: its files are missing.
    """
    folder = settings.bus_certificates
    strategists = strategists_of(settings.strategists)
    wired = (*plant.machines, *plant.stores, GATE, *strategists, HISTORIAN, settings.gateway_name)
    # A vehicle may be linked over another one, and all agents' messages come to it that way.
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
