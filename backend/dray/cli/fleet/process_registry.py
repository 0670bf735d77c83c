"""The registry of a fleet: its processes, with addresses and starts, in a file for other commands."""

from __future__ import annotations

import asyncio
import contextlib
import logging
import os
from enum import StrEnum
from pathlib import Path

import msgspec

from dray.adapters.processes import Process
from dray.adapters.security.identity import Identity
from dray.adapters.zenoh.bus import ZenohBus
from dray.adapters.zenoh.links import Links
from dray.cli.fleet.folder import CERTIFICATES, OBSERVER, REGISTRY
from dray.cli.fleet.process_specs import ProcessSpec
from dray.cli.fleet.software import Software
from dray.cli.runtime.roster import FLOOR
from dray.errors import UnavailableError

OBSERVER_LINKS = 5
"""Links of an observer of a fleet. Every new link is announced to all processes, so one to each process would load a large
fleet. With this number, some unreachable processes cut nobody off."""

ALIVE_S = 3.0
"""Longest wait for an observer's links; they take milliseconds when the computer is not busy."""

ALIVE_AGAIN_S = 0.1

_log = logging.getLogger(__name__)


class State(StrEnum):
    """The state of a process, as its supervisor knows it."""

    AT_WORK = ""
    DRAINING = "draining"
    CANARY = "canary"


class Member(Process, frozen=True, kw_only=True):
    """One process of a fleet.

    Attributes:
        name: its agent's name.
        kind: its kind: atv, machine, station, strategist, historian, gateway or floor.
        address: its listening address.
        starts: number of starts.
        software: the software of its last start.
        proven: the last software that was no canary, for a rollback.
        state: its state.
    """

    name: str
    kind: str
    address: str
    starts: int
    software: Software
    proven: Software
    state: State = State.AT_WORK

    @property
    def joins(self) -> bool:
        """Whether it is an agent on the bus."""
        return self.kind != FLOOR


class ProcessRegistry(msgspec.Struct, frozen=True):
    """All processes of a fleet.

    Attributes:
        plant: the plant's id.
        plain: whether links have no certificates.
        supervisor: the `dray fleet up` that supervises them.
    """

    plant: str
    plain: bool
    supervisor: Process
    members: tuple[Member, ...]

    def member(self, name: str) -> Member:
        """The process of this name, which must be in the fleet."""
        return next(member for member in self.members if member.name == name)

    @property
    def running(self) -> tuple[Member, ...]:
        """The members with a running process."""
        return tuple(member for member in self.members if member.runs)


def read_registry(folder: Path) -> ProcessRegistry:
    """The fleet of a folder.

    Raises:
        UnavailableError: there is none.
    """
    try:
        return msgspec.json.decode((folder / REGISTRY).read_bytes(), type=ProcessRegistry)
    except (OSError, msgspec.MsgspecError) as error:
        reason = (isinstance(error, OSError) and error.strerror) or str(error)
        raise UnavailableError(str(folder / REGISTRY), reason, "start a fleet with `dray fleet up`") from None


def peer_of(registry: ProcessRegistry, folder: Path) -> ZenohBus:
    """A connection to a fleet's bus for an observing command; on the running loop."""
    identity = None if registry.plain else Identity.in_folder(folder / CERTIFICATES, OBSERVER)
    running = registry.running
    linked = running[:: -(-len(running) // OBSERVER_LINKS) or 1]
    peers = tuple(member.address for member in linked)
    return ZenohBus(Links(peers=peers, identity=identity, plain=registry.plain), registry.plant)


async def present_agents(registry: ProcessRegistry, folder: Path) -> frozenset[str]:
    """The agents of a fleet that are on the bus now; waits a little for those with a running process."""
    expected = {member.name for member in registry.running if member.joins}
    bus = peer_of(registry, folder)
    present: frozenset[str] = frozenset()
    try:
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(ALIVE_S):
                present = await bus.agents_present()
                while not expected <= present:
                    await asyncio.sleep(ALIVE_AGAIN_S)
                    present = await bus.agents_present()
    finally:
        bus.close()
    return present


class RegistryWriter:
    """Writes the registry after each change.

    Args:
        folder: the fleet's.
        plant: the plant's id.
        plain: whether links have no certificates.
    """

    def __init__(self, folder: Path, plant: str, *, plain: bool) -> None:
        self._file, self._plant, self._plain = folder / REGISTRY, plant, plain
        self._supervisor = Process.of(os.getpid())
        self._members: dict[str, Member] = {}
        self._grown = asyncio.Event()

    async def has(self, count: int) -> None:
        """Wait until this number of processes was started."""
        while len(self._members) < count:
            self._grown.clear()
            await self._grown.wait()

    def started(self, spec: ProcessSpec, pid: int, software: Software, state: State) -> Member:
        """A process was started, for the first time or again."""
        process, before = Process.of(pid), self._members.get(spec.name)
        member = self._members[spec.name] = Member(
            pid=process.pid,
            born=process.born,
            name=spec.name,
            kind=spec.kind,
            address=spec.address,
            starts=1 if before is None else before.starts + 1,
            software=software,
            proven=software if before is None or state is State.AT_WORK else before.proven,
            state=state,
        )
        self._write()
        self._grown.set()
        return member

    def entered(self, name: str, state: State) -> None:
        """A started process has another state now."""
        member = self._members[name]
        proven = member.software if state is State.AT_WORK else member.proven
        self._members[name] = msgspec.structs.replace(member, state=state, proven=proven)
        self._write()

    def close(self) -> None:
        """Write that no process runs any more."""
        self._file.unlink(missing_ok=True)

    def _write(self) -> None:
        registry = ProcessRegistry(self._plant, self._plain, self._supervisor, tuple(self._members.values()))
        # Replaced atomically: a reader sees the old list or the new one.
        fresh = self._file.with_suffix(".new")
        try:
            fresh.write_bytes(msgspec.json.encode(registry))
            fresh.replace(self._file)
        except OSError as error:
            # The processes continue all the same, and the next change retries.
            _log.warning("%s is not up to date for other commands: %s", self._file, error)
