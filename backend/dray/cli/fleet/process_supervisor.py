"""A supervisor of one process: it restarts the process after each end, as a service manager does, and replaces it on request."""

from __future__ import annotations

import asyncio
import contextlib
import logging
import signal
import time
from collections.abc import Mapping
from dataclasses import dataclass

import msgspec

from dray.cli.fleet.process_registry import RegistryWriter, State
from dray.cli.fleet.process_specs import ProcessSpec
from dray.cli.fleet.software import Software
from dray.cli.runtime.readiness import listening

REST_S = 1.0
"""Seconds before a restart: a process that ends at once must not take over the computer."""

REST_MAX_S = 60.0
"""Maximum delay of a restart, doubled after each short life: the obstacle may be gone by then."""

STEADY_S = 60.0
"""Seconds after which a life counts as stable: its end is unrelated to earlier ones."""

READY_S = 60.0
"""Longest time that a starting process without a ready message delays the start of others."""

STOP_S = 10.0
"""Seconds for an immediate end; then the process is killed."""

_log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Filling:
    """The configuration of a process's next starts.

    Attributes:
        software: its software.
        canary_tasks: tasks that every life must do well as a canary; 0 for none.
    """

    software: Software
    canary_tasks: int = 0

    @property
    def state(self) -> State:
        """The state of a process started like this."""
        return State.CANARY if self.canary_tasks else State.AT_WORK


class Replaced(msgspec.Struct, frozen=True, tag=True):
    """The result of a replacement.

    Attributes:
        left_s: real seconds until the old one had ended.
        killed: whether it had to be killed.
        starts: number of starts, including the new process.
    """

    left_s: float
    killed: bool
    starts: int


class ProcessSupervisor:
    """Supervises one process.

    Args:
        spec: the process.
        registry: records every start.
        turns: limits concurrent starts; held from a start until the process is ready.
        leave_s: real seconds for a graceful shutdown.
        filling: the initial configuration.
    """

    def __init__(
        self,
        spec: ProcessSpec,
        registry: RegistryWriter,
        turns: asyncio.Semaphore,
        leave_s: float,
        filling: Filling,
    ) -> None:
        self._spec, self._registry, self._turns = spec, registry, turns
        self._leave_s = leave_s
        self._filling = filling
        self._process: asyncio.subprocess.Process | None = None
        self._starting = asyncio.Lock()
        """Held during a start: outside it, the process runs or has not begun."""
        self._replacing = asyncio.Lock()
        self._hurry = asyncio.Event()
        """Set to skip the delay before a restart."""
        self._rest_s = REST_S
        """The delay of the next restart, if the process ends by itself."""
        self._away_s: float | None = None
        """The delay after the next end; None for the usual one."""
        self._next_start: asyncio.Future[int] = asyncio.get_running_loop().create_future()

    async def keep(self) -> None:
        """Start the process, and restart it after each end; on cancellation, end it at once.

        Returns when it has ended and cannot be restarted.
        """
        while True:
            began_s = time.monotonic()
            try:
                async with self._turns:
                    await self._begin()
                if self._process is not None:
                    await self._process.wait()
            except BaseException:
                if self._process is not None:
                    await _end(self._process)
                raise
            self._process = None
            if not self._spec.comes_back:
                return
            rest_s = self._rest(time.monotonic() - began_s)
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(rest_s):
                    await self._hurry.wait()

    def _rest(self, lived_s: float) -> float:
        """The delay before the restart of a process that has ended."""
        if self._away_s is not None:
            rest_s, self._away_s = self._away_s, None
            return rest_s
        rest_s = REST_S if lived_s >= STEADY_S else self._rest_s
        self._rest_s = min(2.0 * rest_s, REST_MAX_S)
        if rest_s > REST_S:
            name, lived = self._spec.name, f"{lived_s:.0f} s"
            _log.warning("%s has ended again, after %s: it is started in %.0f s", name, lived, rest_s)
        return rest_s

    def kill(self, away_s: float) -> bool:
        """Kill the process, and keep it down, like a computer that stays off.

        Args:
            away_s: real seconds before the restart; a replacement ends the delay.

        Returns:
            False when nothing runs, or the process is already killed.
        """
        process = self._process
        if process is None or process.returncode is not None or self._away_s is not None:
            return False
        self._away_s = away_s
        process.kill()
        return True

    async def replace(self, filling: Filling, *, at_once: bool) -> Replaced:
        """Shut the process down, and start another one; replacements run one after the other.

        Args:
            filling: the configuration for all later starts, too.
            at_once: whether to end it without a graceful shutdown.

        Raises:
            OSError: the new one cannot be started.
        """
        async with self._replacing:
            began_s = time.monotonic()
            async with self._starting:
                self._filling, process = filling, self._process
                started = self._next_start
            killed = False
            if process is not None:
                self._registry.entered(self._spec.name, State.DRAINING)
                killed = await (_end(process) if at_once else _leave(process, self._leave_s))
            left_s = time.monotonic() - began_s
            self._hurry.set()
            starts = await started
            # The earlier software's failures say nothing about this one.
            self._rest_s = REST_S
            return Replaced(left_s, killed, starts)

    def settle(self) -> None:
        """It has passed: no later life is a canary."""
        self._filling = Filling(self._filling.software)
        self._registry.entered(self._spec.name, State.AT_WORK)

    async def _begin(self) -> None:
        """Start it, and wait until it is ready or has ended, with a timeout for the sake of the others.

        A failed start, by a full disk, say, is retried later.
        """
        try:
            with listening() as listener:
                process = await self._start(listener.environment)
                waits = asyncio.create_task(listener.ready()), asyncio.create_task(process.wait())
                try:
                    await asyncio.wait(waits, timeout=READY_S, return_when=asyncio.FIRST_COMPLETED)
                finally:
                    for each in waits:
                        each.cancel()
        except OSError as error:
            _log.warning("%s cannot be started: %s", self._spec.name, error)
            if self._process is not None:
                await _end(self._process)
            self._answer(error)

    async def _start(self, told: Mapping[str, str]) -> asyncio.subprocess.Process:
        """Start it with additional variables.

        Raises:
            OSError: starting failed.
        """
        async with self._starting:
            spec, filling = self._spec, self._filling
            self._hurry.clear()
            with spec.log.open("ab") as log:
                try:
                    process = self._process = await asyncio.create_subprocess_exec(
                        *filling.software.command(*spec.command, *spec.probation(filling.canary_tasks)),
                        env=filling.software.environment({**spec.environment, **told}),
                        # The gateway prints the panels' address on the terminal.
                        stdout=None if spec.speaks else log,
                        stderr=log,
                        # Ctrl-C is for us; we signal it.
                        start_new_session=True,
                    )
                except OSError as error:
                    log.write(f"{filling.software.python}: {error}\n".encode())
                    raise
            member = self._registry.started(spec, process.pid, filling.software, filling.state)
            self._answer(member.starts)
        return process

    def _answer(self, outcome: int | OSError) -> None:
        """Give waiting callers the number of starts, or the error of the failed start."""
        waiting, self._next_start = self._next_start, asyncio.get_running_loop().create_future()
        if isinstance(outcome, OSError):
            waiting.set_exception(outcome)
            # There may be no waiting caller.
            waiting.exception()
        else:
            waiting.set_result(outcome)


async def _leave(process: asyncio.subprocess.Process, within_s: float) -> bool:
    """Shut it down gracefully; returns whether it had to be killed."""
    return await _told(process, signal.SIGTERM, within_s + STOP_S)


async def _end(process: asyncio.subprocess.Process) -> bool:
    """End it at once; returns whether it had to be killed."""
    return await _told(process, signal.SIGINT, STOP_S)


async def _told(process: asyncio.subprocess.Process, word: signal.Signals, within_s: float) -> bool:
    with contextlib.suppress(ProcessLookupError):
        process.send_signal(word)
        try:
            async with asyncio.timeout(within_s):
                await process.wait()
        except TimeoutError:
            process.kill()
            await process.wait()
            return True
    return False
