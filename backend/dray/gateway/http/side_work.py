"""Side work: slow computations in bounded processes beside the gateway.

Threads would not do: code that holds the interpreter there also blocks the event loop and the stop path's
thread. The processes are started on demand, and kept.
"""

from __future__ import annotations

import asyncio
import pickle
import sys
from asyncio.subprocess import PIPE, Process
from collections import Counter
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from http import HTTPStatus
from typing import TypeVar, TypeVarTuple, cast

from dray.gateway.http.bounded_process import end, start_bounded
from dray.gateway.http.problems import Problem
from dray.gateway.http.side_process import LENGTH, Outcome, framed

T = TypeVar("T")
Ts = TypeVarTuple("Ts")

PLACES = 2
"""Concurrent pieces, one per caller: a long piece leaves a place for all others."""

EACH = 4
"""Maximum pieces per caller, running or waiting: a person with an editor in two windows has two."""

WAITING = 16
"""Maximum pieces of all callers. A piece holds its arguments several times over, at most a file of
`DRAY_BODY_LIMIT_BYTES`."""

WORK_S = 30.0
"""Maximum processor seconds per piece: twenty times what a plant of 7,000 nodes takes."""

MOST_S = 120.0
"""Maximum wall seconds per piece: it stands back, so on a busy computer it takes some times its processor
seconds."""

MOST_BYTES = 1024**3
"""Maximum memory per process; the longest plant file takes a third of that."""

COMMAND = (sys.executable, "-m", "dray.gateway.http.side_process", f"{WORK_S:g}")


class SideWork:
    """A few processes beside the gateway, and a short queue for them.

    Args:
        command: command that starts a process; its last argument is the maximum of processor seconds per piece.
        most_s: maximum wall seconds per piece.
    """

    def __init__(self, command: tuple[str, ...] = COMMAND, most_s: float = MOST_S) -> None:
        self._command, self._most_s = command, most_s
        self._places = asyncio.Semaphore(PLACES)
        self._given: Counter[str] = Counter()
        """Number of pieces per caller."""
        self._turns: dict[str, asyncio.Lock] = {}
        """Per caller with pieces, its lock: one piece at a time."""
        self._free: list[Process] = []
        self._all: set[Process] = set()

    async def do(self, caller: str, work: Callable[[*Ts], T], *given: *Ts) -> T:
        """Run a function in another process when its turn comes.

        Args:
            caller: the caller.
            work: a function of a module. It, its arguments and its result are pickled on the event loop:
                bytes and texts cost nothing there, trees of values do.
            given: its arguments.

        Raises:
            Problem: 429, the caller has too many pieces; 503, there are too many in all; 422, it exceeds its
                time or memory.
            Exception: any exception of `work`.
        """
        async with self.turn(caller):
            return await self.run(work, *given)

    @asynccontextmanager
    async def turn(self, caller: str) -> AsyncIterator[None]:
        """Have a place as long as the context lasts, for `run`.

        Raises:
            Problem: 429, the caller has too many pieces; 503, there are too many in all.
        """
        if self._given[caller] >= EACH:
            raise _too_many(HTTPStatus.TOO_MANY_REQUESTS, f"{EACH} of yours are; wait for their answers")
        if self._given.total() >= WAITING:
            raise _too_many(HTTPStatus.SERVICE_UNAVAILABLE, "try again in some seconds")
        self._given[caller] += 1
        try:
            async with self._turns.setdefault(caller, asyncio.Lock()), self._places:
                yield
        finally:
            self._given[caller] -= 1
            if not self._given[caller]:
                del self._given[caller], self._turns[caller]

    async def run(self, work: Callable[[*Ts], T], *given: *Ts) -> T:
        """Run a function in another process now. Only within a `turn`.

        Raises:
            Problem: 422, it exceeds its time or memory.
            Exception: any exception of `work`.
        """
        result, error = await self._outcome(framed((work, given)))
        if error is not None:
            raise error
        return cast(T, result)

    async def close(self) -> None:
        """End all processes; harmless when done twice."""
        self._free.clear()
        for process in tuple(self._all):
            await self._end(process)

    async def _outcome(self, piece: bytes) -> Outcome:
        process, outcome = await self._process(), None
        try:
            async with asyncio.timeout(self._most_s):
                outcome = await _answered(process, piece)
        except (TimeoutError, EOFError, ConnectionError):
            raise Problem(
                HTTPStatus.UNPROCESSABLE_ENTITY,
                "too-much-work",
                "This takes too long to work out",
                f"it was given up after {WORK_S:g} s of work, {self._most_s:g} s in all, or "
                f"{MOST_BYTES // 1024**2} MiB of memory; send less at once",
            ) from None
        finally:
            if outcome is None:
                # Still busy: it is late, or the caller has gone.
                await self._end(process)
        self._free.append(process)
        return outcome

    async def _process(self) -> Process:
        while self._free:
            process = self._free.pop()
            if process.returncode is None:
                return process
            self._all.discard(process)
        process = await start_bounded(self._command, MOST_BYTES, stdin=PIPE)
        self._all.add(process)
        return process

    async def _end(self, process: Process) -> None:
        self._all.discard(process)
        await end(process)


async def _answered(process: Process, piece: bytes) -> Outcome:
    """Send a piece to a process, and wait for its outcome.

    Raises:
        EOFError: the process has ended.
        ConnectionError: the process has ended.
    """
    assert process.stdin is not None  # noqa: S101 - it was started with both
    assert process.stdout is not None  # noqa: S101
    process.stdin.write(piece)
    await process.stdin.drain()
    (length,) = LENGTH.unpack(await process.stdout.readexactly(LENGTH.size))
    return cast(Outcome, pickle.loads(await process.stdout.readexactly(length)))  # noqa: S301 - our own process


def _too_many(status: HTTPStatus, remedy: str) -> Problem:
    return Problem(
        status,
        "too-many-files",
        "Too many files are being read at this moment",
        remedy,
        headers={"Retry-After": "5"},
    )
