"""A fleet that runs in a folder as long as it is measured."""

from __future__ import annotations

import asyncio
import os
import signal
import sys
from collections import deque
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager, contextmanager, suppress
from pathlib import Path

from dray.adapters.zenoh.bus import ZenohBus
from dray.cli.fleet import control
from dray.cli.fleet.ending import end_fleet
from dray.cli.fleet.folder import JOURNALS, LOGS, read_settings
from dray.cli.fleet.process_registry import ProcessRegistry, peer_of, read_registry
from dray.cli.runtime.listener import url_of
from dray.errors import UnavailableError
from dray.gateway.access.tokens import new_token
from dray.gateway.live.timescale import TimeScale
from dray.plant import Plant, plant_yaml
from dray.settings import PREFIX

START_S = 600.0
"""Longest time for dozens of processes to start and import, on a busy computer."""

STOP_S = 60.0
"""Longest time for a fleet to end gracefully, on a busy computer; then it is killed."""

STARTED = " processes; "
"""Part of the line that reports that all processes were started."""

LINES_SHOWN = 10
"""Last lines of a fleet's output or of a process's log that a complaint quotes."""


class Fleet:
    """A running fleet.

    Args:
        folder: its own.
        token: of its administrator.

    Attributes:
        url: of its gateway.
        time: the plant's clock and the wall's.
        journals: the folder of its agents' journals.
    """

    def __init__(self, folder: Path, token: str) -> None:
        self.token = token
        self.journals = folder / JOURNALS
        self._folder = folder
        settings = read_settings(folder)
        self.url = url_of(settings.host, settings.port)
        self.database_url = settings.database_url
        self.time = TimeScale(settings.plant_epoch_s, settings.plant_epoch_s, settings.plant_speed)

    @property
    def registry(self) -> ProcessRegistry:
        """The running processes."""
        return read_registry(self._folder)

    def kill(self, name: str) -> bool:
        """Kill a process as a power failure does; False when it had ended by itself."""
        return self.registry.member(name).signal(signal.SIGKILL)

    async def take_away(self, name: str, away_s: float) -> bool:
        """Kill a process and keep it away for so many real seconds; False when it had ended by itself."""
        return await control.kill(self._folder, name, away_s)

    def last_words(self, name: str) -> str:
        """The end of a process's log, for finding faults."""
        try:
            lines = (self._folder / LOGS / f"{name}.log").read_text(errors="replace").splitlines()
        except OSError as error:
            return f"{name} has no log: {error.strerror}"
        return "\n".join((f"the log of {name} ends with:", *lines[-LINES_SHOWN:]))

    @contextmanager
    def bus(self) -> Iterator[ZenohBus]:
        """A place on its bus for an observer, as long as the context lasts."""
        bus = peer_of(self.registry, self._folder)
        try:
            yield bus
        finally:
            bus.close()


@asynccontextmanager
async def running(
    folder: Path,
    plant: Plant,
    *,
    speed: float,
    plain: bool,
    lease_s: float | None = None,
    database_url: str = "",
    demand: bool = False,
    traffic: bool | None = None,
    traffic_log: Path | None = None,
    stop_port: int | None = None,
) -> AsyncIterator[Fleet]:
    """A fleet; it has ended when the context has.

    Args:
        folder: an empty one.
        plant: the factory.
        speed: factory seconds per real second.
        plain: links without certificates.
        lease_s: of its links; None for the usual one.
        database_url: empty for SQLite in the folder.
        demand: whether it places orders itself.
        traffic: whether vehicles drive with right of way; None: as `dray fleet up` does.
        traffic_log: where agents log their messages of right of way; None for nowhere.
        stop_port: where its gateway takes stops; None for the port behind its own, or any other.

    Raises:
        UnavailableError: it does not start.
    """
    file, token = folder / "plant.yaml", new_token()
    file.write_text(plant_yaml(plant), encoding="utf-8")
    options = ["--folder", str(folder), "--plant", str(file), "--port", "0", "--speed", str(speed)]
    database_url = database_url or f"sqlite:///{(folder / 'dray.db').resolve()}"
    options += ["--demand" if demand else "--no-demand", *(["--plain"] if plain else [])]
    own = {} if lease_s is None else {f"{PREFIX}BUS_LEASE_S": str(lease_s)}
    if traffic is not None:
        options.append("--traffic" if traffic else "--no-traffic")
    if traffic_log is not None:
        own[f"{PREFIX}TRAFFIC_LOG"] = str(traffic_log)
    if stop_port is not None:
        own[f"{PREFIX}STOP_PORT"] = str(stop_port)
    # Our own settings may name a database that is in service: no order of ours belongs there.
    others = {name: value for name, value in os.environ.items() if not name.startswith(PREFIX)}
    process = await asyncio.create_subprocess_exec(
        *(sys.executable, "-m", "dray", "fleet", "up", "--db", database_url, *options),
        env={**others, **own, f"{PREFIX}ADMIN_TOKEN": token},
        stdout=asyncio.subprocess.PIPE,
        stderr=asyncio.subprocess.STDOUT,
    )
    words = _Words(process)
    listening = asyncio.create_task(words.listen())
    try:
        await words.until_started()
        yield Fleet(folder, token)
    finally:
        await _end(process, folder)
        listening.cancel()


async def _end(process: asyncio.subprocess.Process, folder: Path) -> None:
    """Let it end gracefully, or else at once; and with it all that it has started."""
    if process.returncode is None:
        process.terminate()
    try:
        async with asyncio.timeout(STOP_S):
            await process.wait()
    except TimeoutError:
        process.kill()
        await process.wait()
    # A fleet that has ended gracefully is no longer running.
    with suppress(UnavailableError):
        await end_fleet(folder)


class _Words:
    """Reads a fleet's output; a full pipe would hold the fleet up."""

    def __init__(self, process: asyncio.subprocess.Process) -> None:
        self._out = process.stdout
        self._last: deque[str] = deque(maxlen=LINES_SHOWN)
        self._started, self._ended = asyncio.Event(), False

    async def listen(self) -> None:
        """Read until the output ends."""
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
            raise UnavailableError("the fleet", f"not started in {START_S:.0f} s", self._said()) from None
        if self._ended:
            raise UnavailableError("the fleet", "has ended", self._said())

    def _said(self) -> str:
        return f"it has said last:\n{''.join(self._last)}"
