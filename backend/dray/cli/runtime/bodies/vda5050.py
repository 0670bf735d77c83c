"""Vehicles behind a broker, by VDA 5050."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager
from dataclasses import dataclass

from dray.adapters.journal.sqlite_journal import SqliteJournal
from dray.adapters.memory_file import MemoryFile
from dray.adapters.vda5050.body import HEARD, Address, VehicleBody
from dray.adapters.vda5050.control.master import MasterControl
from dray.adapters.vda5050.dialogue import Head, Recorder
from dray.adapters.vda5050.events import DAMAGED, Memory
from dray.adapters.vda5050.link import BrokerAddress, MqttLink
from dray.adapters.vda5050.profile import Profile, load_profile
from dray.adapters.zenoh.bus import ZenohBus
from dray.cli.runtime.bodies.broker import broker_of
from dray.cli.runtime.bodies.embodied import REMIND_EVERY_S, Embodied, Embody, remembered
from dray.cli.runtime.surroundings import Surroundings
from dray.errors import SettingsError
from dray.plant.model import VehicleType
from dray.settings import Settings

LOOK_EVERY_S = 0.2
"""Seconds between checks what is missing until the vehicle has told its place."""


_log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class RealVehicle:
    """A vehicle behind a broker.

    Attributes:
        broker: the broker's address.
        address: the vehicle's address in topics.
        profile: its profile.
    """

    broker: BrokerAddress
    address: Address
    profile: Profile

    @classmethod
    def of(cls, settings: Settings) -> RealVehicle:
        """The vehicle in the settings.

        Raises:
            SettingsError: something is missing, or unusable.
        """
        for name, value in (
            ("broker", settings.broker),
            ("manufacturer", settings.manufacturer),
            ("serial", settings.serial),
        ):
            if not value:
                raise SettingsError(f"--{name}", f"a body by VDA 5050 needs it; or DRAY_{name.upper()}")
        return cls(
            broker_of(settings),
            Address(settings.manufacturer, settings.serial),
            load_profile(settings.profile),
        )

    def link(self, client: str) -> MqttLink:
        """A link to its broker.

        Args:
            client: our client name there; a second client of this name ends the first.
        """
        prefix = self.profile.topic(self.address.manufacturer, self.address.serial, "").rstrip("/")
        return MqttLink(self.broker, prefix, client, HEARD)


class World:
    """The surroundings of a vehicle's body, beside its clock: a link, a disk, a log."""

    def __init__(self, link: MqttLink, memory: Callable[[Memory], None], name: str) -> None:
        self._link, self._memory, self._name = link, memory, name

    def publish(self, topic: str, data: bytes) -> None:
        self._link.publish(topic, data)

    def remember(self, memory: Memory) -> None:
        self._memory(memory)

    def note(self, text: str) -> None:
        _log.warning("%s: %s", self._name, text)


def by_vda5050(surroundings: Surroundings, name: str, kind: VehicleType, real: RealVehicle) -> Embody:
    """A real vehicle.

    Args:
        surroundings: the process's surroundings.
        name: the agent's id.
        kind: the vehicle's type in the plant.
        real: the vehicle.
    """

    @asynccontextmanager
    async def embody(_bus: ZenohBus, journal: SqliteJournal) -> AsyncIterator[Embodied]:
        file = MemoryFile(surroundings.settings.journal_folder / f"{name}.vda5050.json", Memory, DAMAGED)
        link = real.link(f"dray-{name}")
        memory = remembered(file, name) or Memory()
        control = MasterControl(
            name, surroundings.plant, kind, real.profile, life=journal.incarnation, memory=memory
        )
        body = VehicleBody(
            control,
            real.profile,
            real.address,
            surroundings.clock(),
            World(link, file.write, name),
            surroundings.time.to_wall_s,
        )
        if (folder := surroundings.settings.vehicle_log) is not None:
            head = Head(name, surroundings.plant.id, kind.id, real.profile, journal.incarnation, memory)
            body.record = Recorder(folder / f"{name}-{journal.incarnation}.jsonl", head).write
        async with linked(link, body) as lost, reminded(body, name):
            yield Embodied(body, lost, (link.failures, body.failures))

    return embody


@asynccontextmanager
async def linked(link: MqttLink, body: VehicleBody) -> AsyncIterator[Callable[[], Awaitable[None]]]:
    """Run a vehicle's link as long as the context lasts.

    Yields:
        A function that returns or raises when the link has ended by a fault of ours, and never otherwise.
    """
    running = asyncio.create_task(link.run(body))

    async def lost() -> None:
        await asyncio.shield(running)

    try:
        yield lost
    finally:
        body.end()
        running.cancel()
        await asyncio.gather(running, return_exceptions=True)


@asynccontextmanager
async def reminded(body: VehicleBody, name: str) -> AsyncIterator[None]:
    """Log what is missing until the vehicle has told its place: agent, vehicle and broker may be started in any order."""
    reminding = asyncio.create_task(_remind(body, name))
    try:
        yield
    finally:
        reminding.cancel()
        await asyncio.gather(reminding, return_exceptions=True)


async def _remind(body: VehicleBody, name: str) -> None:
    waited_s, told = REMIND_EVERY_S, ""
    while not await _is_placed(body, LOOK_EVERY_S):
        waited_s += LOOK_EVERY_S
        why = body.control.why_unknown
        if waited_s >= REMIND_EVERY_S or why != told:
            _log.warning("%s waits for its vehicle: %s", name, why)
            waited_s, told = 0.0, why


async def _is_placed(body: VehicleBody, within_s: float) -> bool:
    """Wait until the vehicle has told its place, but no longer than this (wall seconds)."""
    try:
        async with asyncio.timeout(within_s):
            return await body.placed.wait()
    except TimeoutError:
        return False
