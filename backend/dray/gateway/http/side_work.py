"""Side work: what takes its time to compute, done beside the gateway, in processes with bounds.

Not on a thread: what holds the interpreter there is waited for by the event loop, too, and by the thread of stops. The processes are
started when they are needed, and kept.
"""

from __future__ import annotations

import asyncio
import pickle
import sys
from asyncio.subprocess import PIPE, Process
from collections import Counter
from collections.abc import Callable
from http import HTTPStatus
from typing import TypeVar, TypeVarTuple, cast

from dray.gateway.http.bounded_process import end, start_bounded
from dray.gateway.http.problems import Problem
from dray.gateway.http.side_process import LENGTH, Outcome, framed

T = TypeVar("T")
Ts = TypeVarTuple("Ts")

PLACES = 2
"""Pieces that are done at the same time, of one caller one: whoever has a long piece leaves a place to all others."""

EACH = 4
"""Pieces of one caller that are done or wait for their turn: a person with an editor in two windows has two."""

WAITING = 16
"""The same of all callers. A piece holds what it was given, which is a file of `DRAY_BODY_LIMIT_BYTES` at most, some times over."""

MOST_S = 30.0
"""Wall seconds for one piece: fifteen times what a plant of 3,500 nodes takes on an idle computer."""

MOST_BYTES = 1024**3
"""Of memory for one process; the longest plant file takes a third of that to read."""

COMMAND = (sys.executable, "-m", "dray.gateway.http.side_process")


class SideWork:
    """Some processes beside the gateway, and a short queue before them.

    Args:
        command: what a process is started by.
        most_s: wall seconds for one piece.
    """

    def __init__(self, command: tuple[str, ...] = COMMAND, most_s: float = MOST_S) -> None:
        self._command, self._most_s = command, most_s
        self._places = asyncio.Semaphore(PLACES)
        self._given: Counter[str] = Counter()
        """Pieces by caller."""
        self._turns: dict[str, asyncio.Lock] = {}
        """By caller who has given any: one of its pieces at a time."""
        self._free: list[Process] = []
        self._all: set[Process] = set()

    async def do(self, caller: str, work: Callable[[*Ts], T], *given: *Ts) -> T:
        """Compute something in another process when it is its turn.

        Args:
            caller: who asks for it.
            work: a function of a module. It is written and read on the event loop, with what it is given and returns: bytes and texts cost
                nothing there, trees of values do.
            given: what it is called with.

        Raises:
            Problem: 429, too much of this caller waits; 503, too much of all; 422, it takes more time or memory than it may.
            whatever `work` raises.
        """
        if self._given[caller] >= EACH:
            raise _too_many(HTTPStatus.TOO_MANY_REQUESTS, f"{EACH} of yours are; wait for their answers")
        if self._given.total() >= WAITING:
            raise _too_many(HTTPStatus.SERVICE_UNAVAILABLE, "try again in some seconds")
        self._given[caller] += 1
        try:
            async with self._turns.setdefault(caller, asyncio.Lock()), self._places:
                result, error = await self._outcome(framed((work, given)))
        finally:
            self._given[caller] -= 1
            if not self._given[caller]:
                del self._given[caller], self._turns[caller]
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
                f"it was given up after {self._most_s:g} s, or {MOST_BYTES // 1024**2} MiB of memory; send less at once",
            ) from None
        finally:
            if outcome is None:
                # It is in the middle of it, whether it is late or whoever asked has gone.
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
    """Give a process a piece, and wait for what comes of it.

    Raises:
        EOFError: the process has ended.
        ConnectionError: likewise.
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
