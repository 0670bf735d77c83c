"""A bounded queue of calls from other threads into one asyncio loop.

A queue wakes the loop once, however much it holds by then, so a burst costs one wake-up. What agents mean
by what crosses is none of this module's business.
"""

from __future__ import annotations

import asyncio
import threading
from collections import Counter, deque
from typing import TYPE_CHECKING, Any

from dray.errors import UnavailableError
from dray.messages import Heartbeat, Message
from dray.supervision import Failures

if TYPE_CHECKING:
    from collections.abc import Callable

    Slot = tuple[Callable[..., object], tuple[Any, ...]]

QUEUE = 20_000
"""Calls that wait to cross. Some seconds of a plant of 300 agents at ten times real time; a side that
is further behind has stopped."""

HEARTBEAT_ROOM = QUEUE // 2
"""From this filling on a heartbeat takes the place of the one before it, if that still waits: the newest
says all that the older ones have said."""

SENDER_ROOM = QUEUE // 8
"""Messages of one sender from the time on at which the queue is half full until it is not any more: nobody fills it
alone."""

ORDER_ROOM = 1_000
"""Beyond `QUEUE`, for orders alone. A gateway joins with a handful of sessions of some ten keys each: who has
ordered so much, and nothing of it was done, is not heard at all."""

CALLS_PER_TURN = 500
"""Calls made before the loop may look at its sockets again: some 5 ms of a gateway's work."""


class Crossing:
    """A bounded queue of calls to be made on another thread's loop, in the order given.

    Policy: from half full on, of the heartbeats of one sender (the first argument: who has said it, or on which
    key) only the newest is kept, and of its other messages `SENDER_ROOM`; full, every message is dropped; all of that
    is counted. Joining, leaving and subscribing are never
    dropped: they are few, and the other side would be wrong for good. They have room of their own beyond the
    rest; where that is full, too, whoever orders is refused, and nothing has changed.

    The bounds hold to within one call for each thread that calls at the same moment. A call that fails is counted, and holds up no other.

    Args:
        loop: where the calls are made.

    Attributes:
        dropped_heartbeats: heartbeats that a newer one has replaced, or that found the queue full.
        dropped_messages: other messages and offers that found it full, or their sender's part of it.
        failures: calls that have failed, by name.
    """

    def __init__(self, loop: asyncio.AbstractEventLoop) -> None:
        self.dropped_heartbeats = 0
        self.dropped_messages = 0
        self.failures = Failures("a call from another thread")
        self._loop = loop
        self._calls: deque[tuple[Callable[..., object], tuple[Any, ...]]] = deque()
        self._beats: dict[Slot, tuple[Any, ...]] = {}
        """The newest of the heartbeats that wait beyond `HEARTBEAT_ROOM`, by all that they do not replace."""
        self._said: Counter[Slot] = Counter()
        """Messages since the queue was half full, by sender and receiver."""
        self._lock = threading.Lock()
        """Held where these two are looked at and changed; what else is shared needs one step of the interpreter."""
        self._awake = False

    @property
    def waiting(self) -> int:
        """Calls that wait to be made."""
        return len(self._calls)

    def say(self, message: Message, call: Callable[..., object], *args: Any) -> None:
        """Cross with something that is said by, or on, the first of `args`: dropped when there is no room."""
        if len(self._calls) < HEARTBEAT_ROOM:
            if self._said:
                self._said.clear()
            self._append(call, args)
        elif isinstance(message, Heartbeat):
            self._say_beat((call, args[:1]), args)
        elif self._has_room((call, args[:1])):
            self.offer(call, *args)
        else:
            self.dropped_messages += 1

    def offer(self, call: Callable[..., object], *args: Any) -> bool:
        """Cross with something whose loss is made up for: it is said again, or whoever asks is told.

        Returns:
            False when there is no room: the call will not be made.
        """
        if len(self._calls) >= QUEUE:
            self.dropped_messages += 1
            return False
        self._append(call, args)
        return True

    def order(self, call: Callable[..., object], *args: Any) -> None:
        """Cross with something that must arrive.

        Raises:
            UnavailableError: `ORDER_ROOM` is full, too; the call will not be made.
        """
        if len(self._calls) >= QUEUE + ORDER_ROOM:
            raise UnavailableError(
                "the other thread",
                f"has {len(self._calls)} calls before it and makes none",
                "end the process",
            )
        self._append(call, args)

    def _append(self, call: Callable[..., object], args: tuple[Any, ...]) -> None:
        self._calls.append((call, args))
        if not self._awake:
            self._wake()

    def _has_room(self, slot: Slot) -> bool:
        """Count one more message of a sender; False when there have been too many."""
        with self._lock:
            self._said[slot] += 1
            return self._said[slot] <= SENDER_ROOM

    def _say_beat(self, slot: Slot, args: tuple[Any, ...]) -> None:
        with self._lock:
            if slot in self._beats:
                self._beats[slot] = args
                self.dropped_heartbeats += 1
            elif len(self._calls) < QUEUE:
                self._beats[slot] = args
                self._append(self._take_beat, (slot,))
            else:
                self.dropped_heartbeats += 1

    def _take_beat(self, slot: Slot) -> None:
        with self._lock:
            args = self._beats.pop(slot)
        slot[0](*args)

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
        # First this: whoever appends from now on wakes us again, so that no call is left behind.
        self._awake = False
        for _ in range(min(CALLS_PER_TURN, len(self._calls))):
            call, args = self._calls.popleft()
            try:
                call(*args)
            except Exception:  # noqa: BLE001 - whatever it is, it is about this one call
                self.failures.note(getattr(call, "__qualname__", type(call).__name__))
        if self._calls and not self._awake:
            self._wake()
