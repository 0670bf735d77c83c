"""A bounded queue of calls from other threads into one asyncio loop.

A queue wakes the loop once, however much it holds by then, so a burst costs one wake-up. What agents mean
by what crosses is none of this module's business.
"""

from __future__ import annotations

import asyncio
import threading
from collections import deque
from typing import TYPE_CHECKING, Any

from dray.messages import Heartbeat, Message

if TYPE_CHECKING:
    from collections.abc import Callable

    Slot = tuple[Callable[..., object], tuple[Any, ...]]

QUEUE = 20_000
"""Calls that wait to cross. Some seconds of a plant of 300 agents at ten times real time; a side that
is further behind has stopped."""

HEARTBEAT_ROOM = QUEUE // 2
"""From this filling on a heartbeat takes the place of the one before it, if that still waits: the newest
says all that the older ones have said."""

CALLS_PER_TURN = 500
"""Calls made before the loop may look at its sockets again: some 5 ms of a gateway's work."""


class _Call:
    """A call that waits; the lock of its queue guards it."""

    __slots__ = ("args", "call", "slot")

    def __init__(self, call: Callable[..., object], args: tuple[Any, ...], slot: Slot | None) -> None:
        self.call, self.args, self.slot = call, args, slot


class Crossing:
    """A bounded queue of calls to be made on another thread's loop, in the order given.

    Policy: from half full on, of heartbeats that differ in their last argument alone only the newest is
    kept; full, every message is dropped; both are counted. Joining, leaving and subscribing are never
    dropped: they are few, and the other side would be wrong for good.

    Args:
        loop: where the calls are made.

    Attributes:
        dropped_heartbeats: heartbeats that a newer one has replaced, or that found the queue full.
        dropped_messages: other messages that found it full.
    """

    def __init__(self, loop: asyncio.AbstractEventLoop) -> None:
        self.dropped_heartbeats = 0
        self.dropped_messages = 0
        self._loop = loop
        self._lock = threading.Lock()
        self._calls: deque[_Call] = deque()
        self._beats: dict[Slot, _Call] = {}
        """Heartbeats that wait beyond `HEARTBEAT_ROOM`, by all that they do not replace."""
        self._awake = False

    def say(self, message: Message, call: Callable[..., object], *args: Any) -> None:
        """Cross with something that is said, the last of `args`: dropped when there is no room."""
        beats = isinstance(message, Heartbeat)
        with self._lock:
            waiting = len(self._calls)
            slot: Slot | None = None
            if beats and waiting >= HEARTBEAT_ROOM:
                slot = (call, args[:-1])
                if older := self._beats.get(slot):
                    older.args = args
                    self.dropped_heartbeats += 1
                    return
            if waiting < QUEUE:
                self._append(call, args, slot)
            elif beats:
                self.dropped_heartbeats += 1
            else:
                self.dropped_messages += 1

    def order(self, call: Callable[..., object], *args: Any) -> None:
        """Cross with something that must arrive."""
        with self._lock:
            self._append(call, args, None)

    def _append(self, call: Callable[..., object], args: tuple[Any, ...], slot: Slot | None) -> None:
        waiting = _Call(call, args, slot)
        self._calls.append(waiting)
        if slot is not None:
            self._beats[slot] = waiting
        if not self._awake:
            self._wake()

    def _wake(self) -> None:
        self._awake = True
        try:
            self._loop.call_soon_threadsafe(self._take)
        except RuntimeError:
            # The other side has closed its loop: nobody is there to hear anything any more.
            self._calls.clear()
            self._beats.clear()
            self._awake = False

    def _take(self) -> None:
        with self._lock:
            # First this: whoever appends from now on wakes us again, so that no call is left behind.
            self._awake = False
            turn = min(CALLS_PER_TURN, len(self._calls))
        try:
            for _ in range(turn):
                call, args = self._pop()
                call(*args)
        finally:
            with self._lock:
                if self._calls and not self._awake:
                    self._wake()

    def _pop(self) -> tuple[Callable[..., object], tuple[Any, ...]]:
        with self._lock:
            waiting = self._calls.popleft()
            if waiting.slot is not None:
                del self._beats[waiting.slot]
            return waiting.call, waiting.args
