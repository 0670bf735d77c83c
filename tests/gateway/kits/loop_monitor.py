"""What an event loop does between two looks at its sockets: the processor's time of each step, by whom it was for.

Processor time is the thread's own (`time.thread_time`), and it is told as that of a quiet computer: a processor that is shared, hot or
old takes longer for the same work, which a yardstick beside the steps shows. What a step takes is measured several times, and the least counts
(`Tries`).
"""

from __future__ import annotations

import asyncio
import gc
import json
import time
from asyncio.events import Handle
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field
from math import inf
from typing import Any

from fastapi import FastAPI

_WHOSE: ContextVar[str] = ContextVar("whose", default="")
"""For whom a step is made; tasks and callbacks have it from what began them."""

CHUNK_BYTES = 64 * 1024
"""Of a body that arrives: what a server reads at once."""


YARDSTICK_S = 0.0050
"""Processor seconds of `yardstick` on the quiet computer on which the bounds were set."""

SLOWEST = 4.0
"""How much slower than that a computer may be. One that is slower still gets no further allowance."""


def yardstick() -> float:
    """Processor seconds of work of the kind that a gateway does: many small objects are made, looked up, sorted and let go."""
    begun_s = time.thread_time()
    made = {f"X{number:05d}": (number, number % 7, str(number)) for number in range(6_000)}
    lines = sorted((each for each in made.values() if each[1]), key=lambda each: each[2])
    assert len(json.dumps(lines)) > len(made)
    return time.thread_time() - begun_s


@dataclass
class LoopMonitor:
    """The longest steps."""

    longest_s: dict[str, float] = field(default_factory=dict)
    """Processor seconds of the longest step, by whom it was for; "" for what nobody asked for."""
    yardstick_s: float = YARDSTICK_S
    """Processor seconds of the yardstick beside these steps."""

    def but(self, *whose: str) -> float:
        """Processor seconds of the longest step of all others."""
        return max(took_s for each, took_s in self.longest_s.items() if each not in whose)

    def ran(self, handle: Handle, took_s: float) -> None:
        """Note a step."""
        whose = handle._context.get(_WHOSE, "")  # type: ignore[attr-defined]
        self.longest_s[whose] = max(took_s, self.longest_s.get(whose, 0.0))


@dataclass
class Tries:
    """Several tries of the same step, told as on a quiet computer.

    The shortest step of all tries goes with the shortest yardstick of all. If each try went by its own yardstick, the least of them would be
    the one whose yardstick was disturbed most.
    """

    least_s: float = inf
    yardstick_s: float = inf

    def note(self, took_s: float, yardstick_s: float) -> None:
        """Note one try."""
        self.least_s, self.yardstick_s = min(self.least_s, took_s), min(self.yardstick_s, yardstick_s)

    @property
    def least_ms(self) -> float:
        """Milliseconds of the shortest step."""
        slower = min(SLOWEST, max(1.0, self.yardstick_s / YARDSTICK_S))
        return 1e3 * self.least_s / slower


def be(whose: str) -> None:
    """Let the steps of this task, and of what it begins from now on, count as somebody's."""
    _WHOSE.set(whose)


@contextmanager
def loop_monitor() -> Iterator[LoopMonitor]:
    """Watch the loops of this thread as long as the context lasts.

    Meanwhile nothing looks for garbage: a full collection looks at all that the process holds, those of other tests included, in whosever step it
    falls.
    """
    monitor, run = LoopMonitor(), Handle._run  # type: ignore[attr-defined]

    def watched(handle: Handle) -> None:
        begun_s = time.thread_time()
        run(handle)
        monitor.ran(handle, time.thread_time() - begun_s)

    collects = gc.isenabled()
    gc.disable()
    before_s = yardstick()
    Handle._run = watched  # type: ignore[attr-defined]
    try:
        yield monitor
    finally:
        Handle._run = run  # type: ignore[attr-defined]
        monitor.yardstick_s = min(before_s, yardstick())
        if collects:
            gc.enable()


@dataclass(frozen=True)
class Asked:
    """A request as it arrives."""

    method: str
    path: str
    body: bytes = b""
    headers: tuple[tuple[str, str], ...] = ()
    query: str = ""


async def ask(app: FastAPI, asked: Asked, whose: str) -> tuple[int, bytes]:
    """Ask an application as a server does, without a client whose own work would count.

    Returns:
        The status and the body, compressed if the headers allow it.
    """
    given = {"host": "dray.test", "content-length": str(len(asked.body)), **dict(asked.headers)}
    scope = {
        "type": "http",
        "asgi": {"version": "3.0"},
        "http_version": "1.1",
        "method": asked.method,
        "scheme": "http",
        "path": asked.path,
        "raw_path": asked.path.encode(),
        "query_string": asked.query.encode(),
        "root_path": "",
        "headers": [(name.lower().encode(), value.encode()) for name, value in given.items()],
        "client": ("127.0.0.1", 1),
        "server": ("dray.test", 80),
    }
    parts = [asked.body[at : at + CHUNK_BYTES] for at in range(0, max(1, len(asked.body)), CHUNK_BYTES)]
    answer: list[dict[str, Any]] = []
    gone = asyncio.Event()

    async def receive() -> dict[str, Any]:
        await asyncio.sleep(0)
        if not parts:
            await gone.wait()
            return {"type": "http.disconnect"}
        part = parts.pop(0)
        return {"type": "http.request", "body": part, "more_body": bool(parts)}

    async def send(message: Any) -> None:
        answer.append(message)

    _WHOSE.set(whose)
    try:
        await asyncio.create_task(app(scope, receive, send))
    finally:
        _WHOSE.set("")
        gone.set()
    return answer[0]["status"], b"".join(part.get("body", b"") for part in answer[1:])
