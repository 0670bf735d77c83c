"""Side work: what takes its time to compute, done beside the event loop, one piece after the other.

One thread for all of it: work that holds the interpreter is not done sooner by two threads, and everybody else
would wait for both.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from http import HTTPStatus
from typing import TypeVar, TypeVarTuple

from dray.gateway.http.problems import Problem
from dray.gateway.http.shares import Shares

T = TypeVar("T")
Ts = TypeVarTuple("Ts")

WAITING = 12
"""Pieces that are done or wait for their turn: one or two seconds of work. A plant imports a file now and then."""

AGAIN_S = 5
"""When to try again: a second of work has long been done then."""


class SideWork:
    """A thread beside the loop, and a short queue before it."""

    def __init__(self) -> None:
        self._thread = ThreadPoolExecutor(1, "dray-side")
        self._given = 0
        self._shares = Shares(WAITING, "files that are being read", again_s=AGAIN_S)

    async def do(self, caller: str, work: Callable[[*Ts], T], *given: *Ts) -> T:
        """Compute something when it is its turn.

        Args:
            caller: for whom, by kind and id.
            work: what is to be computed.
            given: its arguments.

        Raises:
            Problem: 503, too much waits; 429, too much of this caller does.
            whatever `work` raises.
        """
        if self._given >= WAITING:
            raise Problem(
                HTTPStatus.SERVICE_UNAVAILABLE,
                "too-many-files",
                "Too many files are being read at this moment",
                "try again in some seconds",
                headers={"Retry-After": str(AGAIN_S)},
            )
        self._shares.take(caller)
        self._given += 1
        doing = asyncio.get_running_loop().run_in_executor(self._thread, work, *given)
        # Whoever asked may have gone by then; the work goes on, and keeps its place.
        doing.add_done_callback(lambda _doing: self._done(caller))
        return await asyncio.shield(doing)

    def close(self) -> None:
        """Begin no other piece; harmless when done twice."""
        self._thread.shutdown(wait=False, cancel_futures=True)

    def _done(self, caller: str) -> None:
        self._given -= 1
        self._shares.give_back(caller)
