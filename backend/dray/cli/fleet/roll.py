"""The roll of a fleet: who runs, where, and after how many starts, in a file that other commands read."""

from __future__ import annotations

import asyncio
import contextlib
import os
from pathlib import Path

import msgspec

from dray.adapters.zenoh_bus import ZenohBus
from dray.adapters.zenoh_links import Identity, Links
from dray.cli.fleet.folder import CERTIFICATES, GATEWAY, ROLL
from dray.errors import UnavailableError

ROLL_CALL_S = 3.0
"""For the links of whoever asks who is there; they take milliseconds when the computer is not busy."""


class Member(msgspec.Struct, frozen=True):
    """One process.

    Attributes:
        name: of its agent.
        pid: of its last start.
        address: where it is called.
        joins: it is an agent on the bus.
        starts: how often it was started.
    """

    name: str
    pid: int
    address: str
    joins: bool
    starts: int

    @property
    def runs(self) -> bool:
        """Whether the process is there."""
        try:
            os.kill(self.pid, 0)
        except ProcessLookupError:
            return False
        return True


class Roll(msgspec.Struct, frozen=True):
    """All processes of a fleet.

    Attributes:
        plant: the plant's id.
        plain: links have no certificates.
    """

    plant: str
    plain: bool
    members: tuple[Member, ...]


def read_roll(folder: Path) -> Roll:
    """The fleet of a folder.

    Raises:
        UnavailableError: there is none.
    """
    try:
        return msgspec.json.decode((folder / ROLL).read_bytes(), type=Roll)
    except (OSError, msgspec.MsgspecError) as error:
        raise UnavailableError(str(folder / ROLL), str(error), "start a fleet with `dray fleet up`") from None


async def roll_call(roll: Roll, folder: Path) -> frozenset[str]:
    """Who of a fleet is on the bus at this moment; waits a little for those whose process runs."""
    running = [member for member in roll.members if member.runs]
    identity = None if roll.plain else Identity.in_folder(folder / CERTIFICATES, GATEWAY)
    peers = tuple(member.address for member in running)
    expected = {member.name for member in running if member.joins}
    bus = ZenohBus(Links(peers=peers, identity=identity, plain=roll.plain), roll.plant)
    present: frozenset[str] = frozenset()
    try:
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(ROLL_CALL_S):
                while not expected <= present:
                    present = await bus.roll_call()
    finally:
        bus.close()
    return present


class RollKeeper:
    """Writes the roll anew after every start.

    Args:
        folder: the fleet's.
        plant: the plant's id.
        plain: links have no certificates.
    """

    def __init__(self, folder: Path, plant: str, *, plain: bool) -> None:
        self._file, self._plant, self._plain = folder / ROLL, plant, plain
        self._members: dict[str, Member] = {}
        self._grown = asyncio.Event()

    async def has(self, count: int) -> None:
        """Wait until so many processes were started."""
        while len(self._members) < count:
            self._grown.clear()
            await self._grown.wait()

    def started(self, name: str, pid: int, address: str, *, joins: bool) -> None:
        """A process was started, for the first time or again."""
        before = self._members.get(name)
        starts = 1 if before is None else before.starts + 1
        self._members[name] = Member(name, pid, address, joins, starts)
        roll = Roll(self._plant, self._plain, tuple(self._members.values()))
        # Replaced as a whole: a reader sees the old list or the new one.
        fresh = self._file.with_suffix(".new")
        fresh.write_bytes(msgspec.json.encode(roll))
        fresh.replace(self._file)
        self._grown.set()

    def close(self) -> None:
        """Nobody runs any more."""
        self._file.unlink(missing_ok=True)
