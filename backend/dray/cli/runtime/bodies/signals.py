"""Machines, storages and the gate with single-value signals of controllers, by OPC UA or MQTT."""

from __future__ import annotations

import asyncio
import logging
import math
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Generic, Protocol, TypeVar

from msgspec import Struct

from dray.adapters.journal.sqlite_journal import SqliteJournal
from dray.adapters.mapping_file import has_address, load_mapping
from dray.adapters.memory_file import MemoryFile
from dray.adapters.mqtt.link import SignalsOverMqtt
from dray.adapters.mqtt.mapping_file import MqttMapping
from dray.adapters.opcua.mapping_file import OpcUaMapping
from dray.adapters.signals.gate import DAMAGED_SIGNALS, KeptSignals, SignalledGate, settle_s
from dray.adapters.signals.signal import LinkListener, SignalMapping
from dray.adapters.signals.store import DAMAGED_STORE, KeptStore, SignalledStore, rests_s
from dray.adapters.signals.workcell import DAMAGED as DAMAGED_WORKCELL
from dray.adapters.signals.workcell import Kept, SignalledWorkcell
from dray.adapters.zenoh.bus import ZenohBus
from dray.cli.runtime.bodies.broker import broker_of
from dray.cli.runtime.bodies.embodied import BY_SIGNALS, REMIND_EVERY_S, Embodied, Embody, lived
from dray.cli.runtime.surroundings import Surroundings
from dray.errors import SettingsError
from dray.plant.model import MachineSpec
from dray.plant.model import Storage as StorageSpec
from dray.ports import Body, Clock
from dray.settings import Settings
from dray.supervision import Failures

FIRST_S = 10.0
"""Longest wait of a machine or the gate for its controller before it begins without, and reports that."""


SILENT_S = 10.0
"""Real seconds of silence after which the controller of a storage is lost: its agent ends, so that nobody relies on it, and restarts."""


LOOK_S = 0.1
"""Seconds between looks whether such a controller is there."""


SAY_EVERY_S = 5.0
"""Shortest time between two lines of the log about such a controller, however often the reason changes."""

_log = logging.getLogger(__name__)


_Kept = TypeVar("_Kept", bound=Struct)


class _World(Generic[_Kept]):
    """The surroundings of such a body, beside its clock: a link and a disk."""

    def __init__(self, write: Callable[[], None], remember: Callable[[_Kept], None]) -> None:
        self.write, self.remember = write, remember


class SignalsLink(Protocol):
    """A link to a controller with single-value signals.

    Attributes:
        linked: set when its values have come for the first time.
        failures: errors of the listener.
    """

    linked: asyncio.Event
    failures: Failures

    def write(self) -> None:
        """The listener's outputs have changed."""

    async def run(self, listener: LinkListener) -> None:
        """Stay linked until cancelled."""


@dataclass(frozen=True, slots=True)
class RealController:
    """The controller of a machine, of a storage's dock or of the gate.

    Attributes:
        mapping: its signals.
        folder: the mapping file's folder.
        settings: the process's settings, with the secrets.
    """

    mapping: OpcUaMapping | MqttMapping
    folder: Path
    settings: Settings

    @classmethod
    def of(cls, settings: Settings, check: Callable[[SignalMapping], None]) -> RealController:
        """The controller in the settings. Without such a body kind there, the mapping file decides: one for OPC UA has an address.

        Args:
            settings: the process's settings.
            check: raises ValueError for a mapping of another kind of body.

        Raises:
            SettingsError: the mapping is missing or unusable, or the packages for OPC UA are missing.
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
        """Its user's password; empty for none."""
        password = self.settings.opcua_password
        return "" if password is None else password.get_secret_value()

    @property
    def broker(self) -> str:
        """The address of its broker; empty by OPC UA."""
        return str(broker_of(self.settings)) if isinstance(self.mapping, MqttMapping) else ""

    def link(self, client: str) -> SignalsLink:
        """A link that is not running yet.

        Args:
            client: our client name at a broker.
        """
        if isinstance(self.mapping, MqttMapping):
            return SignalsOverMqtt(self.mapping, broker_of(self.settings), client)
        from dray.adapters.opcua.link import OpcUaLink

        return OpcUaLink(self.mapping, self.folder, self.password)

    def surroundings(
        self, name: str, about: str, kind: type[_Kept], damaged: _Kept, *, always: bool = False
    ) -> tuple[SignalsLink, _World[_Kept], _Kept | None]:
        """A link that is not running yet, what a body acts with, and what its file has kept.

        Args:
            name: the agent's id.
            about: the last part of the file's name.
            kind: the type of what is kept.
            damaged: see `MemoryFile`.
            always: see `lived`.

        Raises:
            UnavailableError: the file cannot be read.
        """
        folder = self.settings.journal_folder
        file = MemoryFile(folder / f"{name}.{about}.json", kind, damaged)
        kept, link = lived(folder, name, BY_SIGNALS, file, always=always), self.link(f"dray-{name}")
        return link, _World(link.write, file.write), kept


def by_signals(surroundings: Surroundings, name: str, spec: MachineSpec) -> Embody:
    """A machine with single-value signals. A lost controller is the machine's problem, and does not end its agent.

    Args:
        surroundings: the process's surroundings.
        name: the agent's id.
        spec: the machine.

    Raises:
        SettingsError: the mapping is missing or unusable.
    """
    settings = surroundings.settings
    real = RealController.of(settings, SignalMapping.check_machine)

    @asynccontextmanager
    async def embody(_bus: ZenohBus, _journal: SqliteJournal) -> AsyncIterator[Embodied]:
        link, world, kept = real.surroundings(name, "workcell", Kept, DAMAGED_WORKCELL)
        body = SignalledWorkcell(
            spec,
            surroundings.plant,
            real.mapping,
            surroundings.clock(),
            world,
            kept,
            broker=real.broker,
        )
        running = asyncio.create_task(link.run(body))
        try:
            await _first(running, link)
            if broken := body.sense().broken:
                _log.warning("%s begins all the same: %s", name, broken)
            yield Embodied(body, lambda: asyncio.shield(running), (link.failures,))
        finally:
            running.cancel()
            await asyncio.gather(running, return_exceptions=True)

    return embody


def store_by_signals(surroundings: Surroundings, name: str, spec: StorageSpec) -> Embody:
    """A storage or a warehouse with single-value signals at its dock.

    Its agent waits for the controller, and ends when that has been away for `SILENT_S`.

    Args:
        surroundings: the process's surroundings.
        name: the agent's id.
        spec: the storage.

    Raises:
        SettingsError: the mapping is missing or unusable.
    """
    settings, clock = surroundings.settings, surroundings.clock
    room = {line.material: line.capacity for line in spec.stocks}
    real = RealController.of(settings, lambda mapping: mapping.check_store(room))

    @asynccontextmanager
    async def embody(_bus: ZenohBus, _journal: SqliteJournal) -> AsyncIterator[Embodied]:
        link, world, kept = real.surroundings(name, "store", KeptStore, DAMAGED_STORE)
        now, rest_s = clock(), rests_s(settings.plant_speed)
        body = SignalledStore(spec, real.mapping, now, world, kept, rests_s=rest_s)
        async with waited_for(name, body, link, now, settings.plant_speed) as embodied:
            yield embodied

    return embody


def gate_by_signals(surroundings: Surroundings, name: str) -> Embody:
    """The gate of the delivery warehouses, with a counter and a reader of labels.

    A controller that is away or has a fault, and a count in doubt, are the gate's problem, and do not end its agent.

    Args:
        surroundings: the process's surroundings.
        name: the agent's id.

    Raises:
        SettingsError: the mapping is missing or unusable.
    """
    settings, clock = surroundings.settings, surroundings.clock
    real = RealController.of(settings, lambda mapping: mapping.check_gate())

    @asynccontextmanager
    async def embody(_bus: ZenohBus, _journal: SqliteJournal) -> AsyncIterator[Embodied]:
        link, world, kept = real.surroundings(name, "signals", KeptSignals, DAMAGED_SIGNALS, always=True)
        now, rest_s = clock(), settle_s(settings.plant_speed)
        body = SignalledGate(real.mapping, now, world, kept, settle_s=rest_s, broker=real.broker)
        running = asyncio.create_task(link.run(body))
        log = _AwayLog(name, asyncio.get_running_loop().time)

        async def ends() -> None:
            while not running.done():
                log.look(body.away or body.held, is_heard=link.linked.is_set())
                await asyncio.wait((running,), timeout=LOOK_S)
            running.result()

        try:
            await _first(running, link)
            yield Embodied(body, ends, (link.failures,))
        finally:
            running.cancel()
            await asyncio.gather(running, return_exceptions=True)

    return embody


async def _first(running: asyncio.Task[None], link: SignalsLink) -> None:
    """Wait until a controller is linked, for `FIRST_S` at most."""
    linked = asyncio.create_task(link.linked.wait())
    try:
        await asyncio.wait((running, linked), timeout=FIRST_S, return_when=asyncio.FIRST_COMPLETED)
    finally:
        linked.cancel()


class _Awaited(LinkListener, Body, Protocol):
    """A body that is of no use without its controller."""

    @property
    def away(self) -> str: ...

    @property
    def away_since_s(self) -> float | None: ...


@asynccontextmanager
async def waited_for(
    name: str, body: _Awaited, link: SignalsLink, now: Clock, speed: float
) -> AsyncIterator[Embodied]:
    """Begin once the controller works, and end when it has not for `SILENT_S`.

    Args:
        name: the agent's id.
        body: its body.
        link: the link to its controller.
        now: the plant's clock.
        speed: seconds of that clock per second.
    """
    running = asyncio.create_task(link.run(body))
    log = _AwayLog(name, asyncio.get_running_loop().time)

    async def lost() -> None:
        while body.away_since_s is None or now.now_s() - body.away_since_s < SILENT_S * speed:
            await asyncio.wait((running,), timeout=1.0)
            if running.done():
                running.result()
            log.look(body.away)
        _log.error("%s: %s", name, body.away)

    try:
        while body.away_since_s is not None:
            await asyncio.wait((running,), timeout=LOOK_S)
            if running.done():
                running.result()
            log.look(body.away, is_heard=link.linked.is_set())
        yield Embodied(body, lost, (link.failures,))
    finally:
        running.cancel()
        await asyncio.gather(running, return_exceptions=True)


class _AwayLog:
    """Logs why a controller is away: a new reason after `SAY_EVERY_S` at the earliest, the same one again after `REMIND_EVERY_S`.

    Args:
        name: the agent's id.
        wall_s: real seconds.
    """

    def __init__(self, name: str, wall_s: Callable[[], float]) -> None:
        self._name, self._wall_s = name, wall_s
        self._said, self._said_s, self._begun_s = "", -math.inf, wall_s()

    def look(self, away: str, *, is_heard: bool = True) -> None:
        """Log the reason, if it is time.

        Args:
            away: the reason; empty while the controller works.
            is_heard: whether anything was heard of it yet; until then the reason is logged after `REMIND_EVERY_S` only.
        """
        wall_s = self._wall_s()
        is_new = is_heard and away != self._said and wall_s >= self._said_s + SAY_EVERY_S
        if away and (is_new or wall_s >= max(self._said_s, self._begun_s) + REMIND_EVERY_S):
            self._said, self._said_s = away, wall_s
            _log.warning("%s waits for its controller: %s", self._name, away)
