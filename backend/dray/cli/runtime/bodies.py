"""The bodies of agents in service: on a floor elsewhere, or a real vehicle behind a broker."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import AbstractAsyncContextManager, asynccontextmanager, closing
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Generic, Protocol, TypeVar

from msgspec import Struct

from dray.adapters.controller.body import ControllerBody
from dray.adapters.controller.letters import TOLD, prefix
from dray.adapters.documents import DocumentReader, FetchedDocuments
from dray.adapters.journal.sqlite_journal import SqliteJournal
from dray.adapters.mapping_file import has_address, load_mapping
from dray.adapters.memory_file import MemoryFile
from dray.adapters.mqtt.link import SignalsOverMqtt
from dray.adapters.mqtt.mapping_file import MqttMapping
from dray.adapters.opcua.mapping_file import OpcUaMapping
from dray.adapters.people.gate import DAMAGED_GATE, KeptGate, PeopleGate
from dray.adapters.people.store import DAMAGED_STORE as DAMAGED_PEOPLE_STORE
from dray.adapters.people.store import KeptStore as PeopleKeptStore
from dray.adapters.people.store import PeopleStore
from dray.adapters.people.workcell import DAMAGED as DAMAGED_PEOPLE
from dray.adapters.people.workcell import Kept as PeopleKept
from dray.adapters.people.workcell import PeopleWorkcell
from dray.adapters.remote_body import BodySpec, CountedBody, RemoteBody, put_down, tell_moved
from dray.adapters.signals.signal import LinkListener, SignalMapping
from dray.adapters.signals.store import DAMAGED_STORE, KeptStore, SignalledStore
from dray.adapters.signals.workcell import DAMAGED as DAMAGED_WORKCELL
from dray.adapters.signals.workcell import Kept, SignalledWorkcell
from dray.adapters.vda5050.body import HEARD, Address, VehicleBody
from dray.adapters.vda5050.control.master import MasterControl
from dray.adapters.vda5050.dialogue import Head, Recorder
from dray.adapters.vda5050.events import DAMAGED, Memory
from dray.adapters.vda5050.link import BrokerAddress, MqttLink, read_address
from dray.adapters.vda5050.profile import Profile, load_profile
from dray.adapters.zenoh.bus import ZenohBus
from dray.body import Drop, Pick, StorageState
from dray.cli.runtime.surroundings import Surroundings
from dray.errors import SettingsError, UnavailableError
from dray.gate import GateState
from dray.plant.model import MachineSpec, VehicleType
from dray.plant.model import Storage as StorageSpec
from dray.ports import Body
from dray.settings import Settings
from dray.supervision import Failures

LOOK_EVERY_S = 0.2
"""How often it is looked whether the vehicle has said where it is."""

REMIND_EVERY_S = 30.0
"""How often it is said why an agent does not begin."""

_log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Embodied:
    """A body, and who tells when it is lost.

    Attributes:
        body: the agent's; None for one that only talks.
        lost: returns when it is there no more; never, for one whose absence is a problem and no end.
        failures: of those who hear what it says.
    """

    body: Body | None
    lost: Callable[[], Awaitable[object]]
    failures: tuple[Failures, ...] = ()


Embody = Callable[[ZenohBus, SqliteJournal], AbstractAsyncContextManager[Embodied]]
"""Makes the body of one life of an agent."""


@asynccontextmanager
async def bodiless(_bus: ZenohBus, _journal: SqliteJournal) -> AsyncIterator[Embodied]:
    """The body of an agent that has none."""
    yield Embodied(None, asyncio.Event().wait)


def on_floor(surroundings: Surroundings, name: str, added: BodySpec | None = None) -> Embody:
    """A body on the floor of the plant.

    Args:
        surroundings: of the process.
        name: the agent's id.
        added: its body, when the plant file of the floor does not know it.
    """

    @asynccontextmanager
    async def embody(bus: ZenohBus, journal: SqliteJournal) -> AsyncIterator[Embodied]:
        plant = surroundings.plant
        if added is not None:
            await put_down(bus.inner, plant.id, added)
        body = RemoteBody(bus.inner, plant.id, name, journal.incarnation)
        await body.connect()
        if body.is_new and journal.memory:
            file = surroundings.settings.journal_folder / f"{name}.db"
            remedy = "move away the journals of all agents whose bodies are on that floor"
            raise UnavailableError(
                f"the body that {file} is about", "is gone, for the floor has begun anew", remedy
            )
        yield Embodied(body, body.lost)

    return embody


def reading(embody: Embody, folder: Path) -> Embody:
    """A body that fetches documents and lays them ready in a folder."""

    @asynccontextmanager
    async def with_documents(bus: ZenohBus, journal: SqliteJournal) -> AsyncIterator[Embodied]:
        with closing(FetchedDocuments(folder)) as documents:
            async with embody(bus, journal) as inner:
                assert inner.body is not None  # noqa: S101 - a machine has one
                yield Embodied(DocumentReader(inner.body, documents), inner.lost, inner.failures)

    return with_documents


def broker_of(settings: Settings) -> BrokerAddress:
    """The broker that the settings name.

    Raises:
        SettingsError: they name none.
    """
    if not settings.broker:
        raise SettingsError("DRAY_BROKER", "a real body is behind a broker: say where that is")
    host, port, tls = read_address(settings.broker)
    password = settings.broker_password
    return BrokerAddress(
        host,
        port,
        tls,
        user=settings.broker_user,
        password="" if password is None else password.get_secret_value(),
        authority=settings.broker_authority,
        certificate=settings.broker_certificate,
        key=settings.broker_key,
    )


def by_controller(surroundings: Surroundings, name: str, senses: type[StorageState | GateState]) -> Embody:
    """The controller of a dock.

    Args:
        surroundings: of the process.
        name: the agent's id.
        senses: what the controller tells of itself.
    """

    @asynccontextmanager
    async def embody(_bus: ZenohBus, journal: SqliteJournal) -> AsyncIterator[Embodied]:
        broker = broker_of(surroundings.settings)
        link = MqttLink(broker, prefix(surroundings.plant.id, name), f"dray-{name}", (TOLD,))
        body = ControllerBody(journal.incarnation, senses, link.publish)
        running = asyncio.create_task(link.run(body))
        try:
            while True:
                try:
                    await asyncio.wait_for(body.known(), REMIND_EVERY_S)
                    break
                except TimeoutError:
                    _log.warning("%s waits for its controller at %s", name, broker)
            yield Embodied(body, body.lost, (link.failures,))
        finally:
            running.cancel()
            await asyncio.gather(running, return_exceptions=True)

    return embody


FIRST_S = 10.0
"""So long a machine waits for its controller before it begins without, and says so."""


_Kept = TypeVar("_Kept")
_PeopleKept = TypeVar("_PeopleKept", bound=Struct)


class _World(Generic[_Kept]):
    """What such a body needs beside a clock: a link and a disk."""

    def __init__(self, write: Callable[[], None], remember: Callable[[_Kept], None]) -> None:
        self.write, self.remember = write, remember


class SignalsLink(Protocol):
    """A link to a controller that tells and obeys single values.

    Attributes:
        linked: set once its values could be heard for the first time.
        failures: what the listener could not deal with.
    """

    linked: asyncio.Event
    failures: Failures

    def write(self) -> None:
        """The listener's outputs have changed."""

    async def run(self, listener: LinkListener) -> None:
        """Be linked until cancelled."""


@dataclass(frozen=True, slots=True)
class RealController:
    """The controller of a machine, or of a storage's dock.

    Attributes:
        mapping: which of its values are which signals.
        folder: of the mapping file.
        settings: of the process, with what is secret.
    """

    mapping: OpcUaMapping | MqttMapping
    folder: Path
    settings: Settings

    @classmethod
    def of(cls, settings: Settings, check: Callable[[SignalMapping], None]) -> RealController:
        """What the settings say. Without a body of that kind the mapping file tells it: that of an OPC UA server has an address.

        Args:
            settings: of the process.
            check: raises ValueError where the mapping is not that of such a body.

        Raises:
            SettingsError: there is no mapping, or it cannot be used; or what OPC UA needs is not installed.
        """
        file = settings.mapping
        if file is None:
            reason = "a controller's body needs the file that names its signals; or DRAY_MAPPING"
            raise SettingsError("--mapping", reason)
        named = settings.body in ("opcua", "mqtt")
        mqtt = settings.body == "mqtt" if named else not has_address(file)
        mapping = load_mapping(file, MqttMapping) if mqtt else load_mapping(file, OpcUaMapping)
        if mqtt:
            broker_of(settings)
        elif find_spec("asyncua") is None:
            raise SettingsError("--body", "OPC UA needs more than is installed: pip install 'dray[opcua]'")
        try:
            check(mapping)
        except ValueError as error:
            raise SettingsError("--mapping", f"{file}: {error}") from None
        return cls(mapping, file.parent, settings)

    @property
    def password(self) -> str:
        """Of its user; empty for none."""
        password = self.settings.opcua_password
        return "" if password is None else password.get_secret_value()

    def link(self, client: str) -> SignalsLink:
        """A link that does not run yet.

        Args:
            client: our name at a broker.
        """
        if isinstance(self.mapping, MqttMapping):
            return SignalsOverMqtt(self.mapping, broker_of(self.settings), client)
        from dray.adapters.opcua.link import OpcUaLink

        return OpcUaLink(self.mapping, self.folder, self.password)


def by_signals(surroundings: Surroundings, name: str, spec: MachineSpec) -> Embody:
    """A machine whose controller tells and obeys single values. One that is away is the machine's problem, and no end of its agent.

    Args:
        surroundings: of the process.
        name: the agent's id.
        spec: the machine.

    Raises:
        SettingsError: there is no mapping, or it cannot be used.
    """
    settings = surroundings.settings
    real = RealController.of(settings, SignalMapping.check_machine)

    @asynccontextmanager
    async def embody(_bus: ZenohBus, _journal: SqliteJournal) -> AsyncIterator[Embodied]:
        file = MemoryFile(settings.journal_folder / f"{name}.workcell.json", Kept, DAMAGED_WORKCELL)
        kept = file.read()
        if file.lost:
            _log.error("%s: %s", name, file.lost)
        link = real.link(f"dray-{name}")
        world = _World(link.write, file.write)
        body = SignalledWorkcell(spec, surroundings.plant, real.mapping, surroundings.clock(), world, kept)
        running = asyncio.create_task(link.run(body))
        try:
            await asyncio.wait(
                (running, asyncio.ensure_future(link.linked.wait())),
                timeout=FIRST_S,
                return_when=asyncio.FIRST_COMPLETED,
            )
            if broken := body.sense().broken:
                _log.warning("%s begins all the same: %s", name, broken)
            yield Embodied(body, lambda: asyncio.shield(running), (link.failures,))
        finally:
            running.cancel()
            await asyncio.gather(running, return_exceptions=True)

    return embody


class _PeopleWorld(Generic[_PeopleKept]):
    """What a body of people needs beside a clock: a disk."""

    def __init__(self, remember: Callable[[_PeopleKept], None]) -> None:
        self.remember = remember


def _of_people(
    surroundings: Surroundings,
    name: str,
    kind: type[_PeopleKept],
    damaged: _PeopleKept,
    make: Callable[[_PeopleWorld[_PeopleKept], _PeopleKept | None], Body],
) -> Embody:
    """A body that is people: what they have said is kept in a file of the journal folder."""

    @asynccontextmanager
    async def embody(_bus: ZenohBus, _journal: SqliteJournal) -> AsyncIterator[Embodied]:
        path = surroundings.settings.journal_folder / f"{name}.people.json"
        file = MemoryFile(path, kind, damaged)
        kept = file.read()
        if file.lost:
            _log.error("%s: %s", name, file.lost)
        yield Embodied(make(_PeopleWorld(file.write), kept), asyncio.Event().wait)

    return embody


def by_people(surroundings: Surroundings, name: str, spec: MachineSpec) -> Embody:
    """A machine without a controller, whose people say what has happened.

    Args:
        surroundings: of the process.
        name: the agent's id.
        spec: the machine.
    """
    return _of_people(
        surroundings,
        name,
        PeopleKept,
        DAMAGED_PEOPLE,
        lambda world, kept: PeopleWorkcell(spec, surroundings.plant, surroundings.clock(), world, kept),
    )


def store_by_people(surroundings: Surroundings, name: str, spec: StorageSpec) -> Embody:
    """A storage or a warehouse without a controller, whose people say what has come and gone.

    Args:
        surroundings: of the process.
        name: the agent's id.
        spec: what is kept there.
    """
    return _of_people(
        surroundings,
        name,
        PeopleKeptStore,
        DAMAGED_PEOPLE_STORE,
        lambda world, kept: PeopleStore(spec, world, kept),
    )


def gate_by_people(surroundings: Surroundings, name: str) -> Embody:
    """The gate of the delivery warehouses, whose people say what has arrived.

    Args:
        surroundings: of the process.
        name: the agent's id.
    """
    return _of_people(surroundings, name, KeptGate, DAMAGED_GATE, PeopleGate)


@dataclass(frozen=True, slots=True)
class RealVehicle:
    """A vehicle behind a broker.

    Attributes:
        broker: where it is.
        address: whose topics are the vehicle's.
        profile: what it understands.
    """

    broker: BrokerAddress
    address: Address
    profile: Profile

    @classmethod
    def of(cls, settings: Settings) -> RealVehicle:
        """What the settings say.

        Raises:
            SettingsError: something is missing, or cannot be used.
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
        """To its broker.

        Args:
            client: our name there; a second one of this name ends the first.
        """
        prefix = self.profile.topic(self.address.manufacturer, self.address.serial, "").rstrip("/")
        return MqttLink(self.broker, prefix, client, HEARD)


class World:
    """What a vehicle's body needs beside a clock: a link, a disk, a log."""

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
        surroundings: of the process.
        name: the agent's id.
        kind: what the plant says of the vehicle.
        real: the vehicle.
    """

    @asynccontextmanager
    async def embody(_bus: ZenohBus, journal: SqliteJournal) -> AsyncIterator[Embodied]:
        file = MemoryFile(surroundings.settings.journal_folder / f"{name}.vda5050.json", Memory, DAMAGED)
        link = real.link(f"dray-{name}")
        memory = file.read() or Memory()
        if file.lost:
            _log.error("%s: %s", name, file.lost)
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
        async with linked(link, body) as lost:
            await until_known(body, name)
            yield Embodied(body, lost, (link.failures, body.failures))

    return embody


SILENT_S = 10.0
"""A storage's controller that is away for longer is gone: its agent ends, so that nobody counts on it, and begins anew."""


def store_by_signals(surroundings: Surroundings, name: str, spec: StorageSpec) -> Embody:
    """A storage or a warehouse whose dock's controller tells and obeys single values.

    Its agent waits until the controller is there, and ends when it has been away for `SILENT_S`.

    Args:
        surroundings: of the process.
        name: the agent's id.
        spec: what is kept there.

    Raises:
        SettingsError: there is no mapping, or it cannot be used.
    """
    settings, clock = surroundings.settings, surroundings.clock
    items = {line.material for line in spec.stocks}
    real = RealController.of(settings, lambda mapping: mapping.check_store(items))

    @asynccontextmanager
    async def embody(_bus: ZenohBus, _journal: SqliteJournal) -> AsyncIterator[Embodied]:
        file = MemoryFile(settings.journal_folder / f"{name}.store.json", KeptStore, DAMAGED_STORE)
        kept = file.read()
        if file.lost:
            _log.error("%s: %s", name, file.lost)
        now = clock()
        link = real.link(f"dray-{name}")
        body = SignalledStore(spec, real.mapping, now, _World(link.write, file.write), kept)
        running = asyncio.create_task(link.run(body))

        async def lost() -> None:
            while body.away_since_s is None or now.now_s() - body.away_since_s < SILENT_S:
                await asyncio.wait((running,), timeout=1.0)
                if running.done():
                    running.result()

        try:
            while body.away_since_s is not None:
                there = asyncio.ensure_future(link.linked.wait())
                await asyncio.wait(
                    (running, there), timeout=REMIND_EVERY_S, return_when=asyncio.FIRST_COMPLETED
                )
                there.cancel()
                if running.done():
                    running.result()
                if body.away:
                    _log.warning("%s waits for its controller: %s", name, body.away)
            yield Embodied(body, lost, (link.failures,))
        finally:
            running.cancel()
            await asyncio.gather(running, return_exceptions=True)

    return embody


def counted_on_floor(surroundings: Surroundings, name: str, embody: Embody) -> Embody:
    """The body of a real vehicle whose places are simulated: the floor counts what it picks and drops.

    Args:
        surroundings: of the process.
        name: the agent's id.
        embody: makes the vehicle's own body.
    """

    @asynccontextmanager
    async def with_floor(bus: ZenohBus, journal: SqliteJournal) -> AsyncIterator[Embodied]:
        session, plant, life = bus.inner, surroundings.plant.id, journal.incarnation
        await tell_moved(session, plant, name, life)

        async def tell(done: Pick | Drop) -> str:
            return await tell_moved(session, plant, name, life, done)

        async with embody(bus, journal) as inner:
            assert inner.body is not None  # noqa: S101 - a vehicle has one
            body = CountedBody(name, inner.body, tell)
            telling = asyncio.ensure_future(body.run())
            gone = asyncio.ensure_future(inner.lost())

            async def lost() -> None:
                ended, _ = await asyncio.wait((telling, gone), return_when=asyncio.FIRST_COMPLETED)
                for each in ended:
                    each.result()

            try:
                yield Embodied(body, lost, inner.failures)
            finally:
                for each in (telling, gone):
                    each.cancel()
                await asyncio.gather(telling, gone, return_exceptions=True)

    return with_floor


@asynccontextmanager
async def linked(link: MqttLink, body: VehicleBody) -> AsyncIterator[Callable[[], Awaitable[None]]]:
    """Keep a vehicle's link as long as the context lasts.

    Yields:
        What returns or raises when the link has ended by a fault of ours; it never does otherwise.
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


async def until_known(body: VehicleBody, name: str) -> None:
    """Wait until the vehicle has said where it is: agent, vehicle and broker may be started in any order."""
    waited_s, told = REMIND_EVERY_S, ""
    while not body.control.is_known:
        await asyncio.sleep(LOOK_EVERY_S)
        waited_s += LOOK_EVERY_S
        why = body.control.why_unknown
        if waited_s >= REMIND_EVERY_S or why != told:
            _log.warning("%s waits for its vehicle: %s", name, why)
            waited_s, told = 0.0, why
