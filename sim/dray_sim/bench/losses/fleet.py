"""A fleet that runs in a folder as long as it is measured."""

from __future__ import annotations

import asyncio
import os
import signal
import socket
import sys
from collections import deque
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager, contextmanager
from pathlib import Path

from dray.adapters.zenoh_bus import ZenohBus
from dray.cli.fleet.folder import JOURNALS, SETTINGS
from dray.cli.fleet.roll import Roll, peer_of, read_roll
from dray.errors import UnavailableError
from dray.gateway.access.tokens import new_token
from dray.gateway.timescale import TimeScale
from dray.plant import Plant, plant_yaml
from dray.settings import PREFIX, Settings

START_S = 600.0
"""For dozens of processes with their imports, on a computer that is busy elsewhere."""

STOP_S = 60.0

STARTED = " processes; "
"""In the line that tells that all of them were started."""

LINES_SHOWN = 10
"""Of what a fleet has said last, when it has ended too early."""


class Fleet:
    """A running fleet.

    Args:
        folder: its own.
        url: of its gateway.
        token: of its administrator.

    Attributes:
        time: the plant's clock and the wall's.
        journals: the folder of its agents' journals.
    """

    def __init__(self, folder: Path, url: str, token: str) -> None:
        self.url, self.token = url, token
        self.journals = folder / JOURNALS
        self._folder = folder
        settings = Settings.load(settings_file=folder / SETTINGS)
        self.database_url = settings.database_url
        self.time = TimeScale(settings.plant_epoch_s, settings.plant_epoch_s, settings.plant_speed)

    @property
    def roll(self) -> Roll:
        """Who runs."""
        return read_roll(self._folder)

    def kill(self, name: str) -> bool:
        """Kill a process as a power failure does; False when it had ended by itself."""
        return self.roll.member(name).signal(signal.SIGKILL)

    @contextmanager
    def bus(self) -> Iterator[ZenohBus]:
        """A place on its bus for an observer, as long as the context lasts."""
        bus = peer_of(self.roll, self._folder)
        try:
            yield bus
        finally:
            bus.close()


@asynccontextmanager
async def running(
    folder: Path, plant: Plant, *, speed: float, plain: bool, lease_s: float | None = None
) -> AsyncIterator[Fleet]:
    """A fleet on SQLite, without a demand of its own; it has ended when the context has.

    Args:
        folder: an empty one.
        plant: the factory.
        speed: factory seconds per real second.
        plain: links without certificates.
        lease_s: of its links; None for the usual one.

    Raises:
        UnavailableError: it does not start.
    """
    file, token, port = folder / "plant.yaml", new_token(), _free_port()
    file.write_text(plant_yaml(plant), encoding="utf-8")
    options = ["--folder", str(folder), "--plant", str(file), "--port", str(port), "--speed", str(speed)]
    lease = {} if lease_s is None else {f"{PREFIX}BUS_LEASE_S": str(lease_s)}
    process = await asyncio.create_subprocess_exec(
        *(sys.executable, "-m", "dray", "fleet", "up", "--no-demand", *options),
        *(["--plain"] if plain else []),
        env={**os.environ, **lease, f"{PREFIX}ADMIN_TOKEN": token},
        stdout=asyncio.subprocess.PIPE,
        stderr=asyncio.subprocess.STDOUT,
    )
    words = _Words(process)
    listening = asyncio.create_task(words.listen())
    try:
        await words.until_started()
        yield Fleet(folder, f"http://127.0.0.1:{port}", token)
    finally:
        if process.returncode is None:
            process.terminate()
        async with asyncio.timeout(STOP_S):
            await process.wait()
        listening.cancel()


class _Words:
    """What a fleet says; nobody else reads it, and a full pipe would hold it up."""

    def __init__(self, process: asyncio.subprocess.Process) -> None:
        self._out = process.stdout
        self._last: deque[str] = deque(maxlen=LINES_SHOWN)
        self._started, self._ended = asyncio.Event(), False

    async def listen(self) -> None:
        """Until it says no more."""
        while self._out is not None and (line := await self._out.readline()):
            self._last.append(line.decode(errors="replace"))
            if STARTED in self._last[-1]:
                self._started.set()
        self._ended = True
        self._started.set()

    async def until_started(self) -> None:
        """Wait until all processes were started.

        Raises:
            UnavailableError: the fleet has ended before, or takes too long.
        """
        try:
            async with asyncio.timeout(START_S):
                await self._started.wait()
        except TimeoutError:
            raise UnavailableError("the fleet", f"not started in {START_S:.0f} s", "see its logs") from None
        if self._ended:
            raise UnavailableError("the fleet", f"has ended: {''.join(self._last)}", "see what it says")


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port: int = probe.getsockname()[1]
        return port
