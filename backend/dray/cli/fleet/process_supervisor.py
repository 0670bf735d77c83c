"""A supervisor of one process: it keeps that process running, as a service manager does, and replaces it when asked."""

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
"""Before a process that has ended is started again: one that ends at once must not take the computer."""

REST_MAX_S = 60.0
"""The rest doubles with every life that was too short, up to this: what hinders it may be over by then."""

STEADY_S = 60.0
"""A process that has lived for so long was well: what ends it has nothing to do with what ended the one before."""

READY_S = 60.0
"""Longest that others wait for their turn to be started because one does not say that it takes part."""

STOP_S = 10.0
"""To end at once; then it is killed."""

_log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Filling:
    """How a process is to be started from now on.

    Attributes:
        software: what runs.
        canary_tasks: tasks that every life has to do well before it counts as one like the others; 0 for none.
    """

    software: Software
    canary_tasks: int = 0

    @property
    def state(self) -> State:
        """What a process is about that was started so."""
        return State.CANARY if self.canary_tasks else State.AT_WORK


class Replaced(msgspec.Struct, frozen=True, tag=True):
    """How a process was replaced.

    Attributes:
        left_s: real seconds until the old one had ended.
        killed: it had to be killed.
        starts: of the process, with the one of the new process.
    """

    left_s: float
    killed: bool
    starts: int


class ProcessSupervisor:
    """Keeps one process running.

    Args:
        spec: what is to be kept.
        registry: where every start is written down.
        turns: held from a start until the process takes part: how many may begin at once.
        leave_s: real seconds in which a process that is asked to shut down gracefully does so.
        filling: how the process is started at first.
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
        """Held while a process is being started: it runs then, or has not begun."""
        self._replacing = asyncio.Lock()
        self._hurry = asyncio.Event()
        """Set: there is no need to rest."""
        self._rest_s = REST_S
        """Before the next start, should the process end by itself."""
        self._away_s: float | None = None
        """How long the process stays away when it ends next; None for as long as usual."""
        self._next_start: asyncio.Future[int] = asyncio.get_running_loop().create_future()

    async def keep(self) -> None:
        """Start the process, and again whenever it ends; when cancelled, let it end at once.

        Returns when it has ended and cannot come back.
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
        """How long the process stays away now that it has ended."""
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
        """Kill the process, and keep it away, as of a computer that stays away.

        Args:
            away_s: real seconds; a replacement ends them.

        Returns:
            False when nothing runs, or what runs is killed already.
        """
        process = self._process
        if process is None or process.returncode is not None or self._away_s is not None:
            return False
        self._away_s = away_s
        process.kill()
        return True

    async def replace(self, filling: Filling, *, at_once: bool) -> Replaced:
        """Let the process leave, and start another one so; one replacement after the other.

        Args:
            filling: holds for all later starts, too.
            at_once: it need not finish what it has begun.

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
            # How often the one before has ended says nothing of this one.
            self._rest_s = REST_S
            return Replaced(left_s, killed, starts)

    def settle(self) -> None:
        """It has passed: no later life is a canary any more."""
        self._filling = Filling(self._filling.software)
        self._registry.entered(self._spec.name, State.AT_WORK)

    async def _begin(self) -> None:
        """Start it, and wait until it takes part, has ended, or must not hold up the others any longer.

        What hinders a start, a full disk say, may be over at the next one.
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
        """Start it with these variables, too.

        Raises:
            OSError: that cannot be done.
        """
        async with self._starting:
            spec, filling = self._spec, self._filling
            self._hurry.clear()
            with spec.log.open("ab") as log:
                try:
                    process = self._process = await asyncio.create_subprocess_exec(
                        *filling.software.command(*spec.command, *spec.probation(filling.canary_tasks)),
                        env=filling.software.environment({**spec.environment, **told}),
                        # The gateway tells on the terminal where the panels are.
                        stdout=None if spec.speaks else log,
                        stderr=log,
                        # Ctrl-C is for us; we tell them.
                        start_new_session=True,
                    )
                except OSError as error:
                    log.write(f"{filling.software.python}: {error}\n".encode())
                    raise
            member = self._registry.started(spec, process.pid, filling.software, filling.state)
            self._answer(member.starts)
        return process

    def _answer(self, outcome: int | OSError) -> None:
        """Tell whoever waits for the next start how often it was started, or why it was not."""
        waiting, self._next_start = self._next_start, asyncio.get_running_loop().create_future()
        if isinstance(outcome, OSError):
            waiting.set_exception(outcome)
            # Nobody may wait.
            waiting.exception()
        else:
            waiting.set_result(outcome)


async def _leave(process: asyncio.subprocess.Process, within_s: float) -> bool:
    """Let it finish what it has begun; whether it had to be killed."""
    return await _told(process, signal.SIGTERM, within_s + STOP_S)


async def _end(process: asyncio.subprocess.Process) -> bool:
    """Let it end as it stands; whether it had to be killed."""
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
