"""A bounded queue of calls from other threads into one asyncio loop.

A queue wakes the loop once, however full it is, so a burst costs one wake-up. This module does not know the meaning of
the calls.
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
"""Maximum waiting calls: some seconds of a plant of 300 agents at ten times real time. A side further behind has
stopped."""

HEARTBEAT_ROOM = QUEUE // 2
"""The filling above which a heartbeat replaces the previous one still waiting: the newest contains all that the older ones
said."""

SENDER_ROOM = QUEUE // 8
"""Maximum messages of one sender, counted while the queue is at least half full, so that no sender fills it alone."""

ORDER_ROOM = 1_000
"""Maximum calls beyond `QUEUE`, for `order` alone. A gateway joins with a handful of sessions of some ten keys each. So only
a hung other side fills it."""

CALLS_PER_TURN = 500
"""Maximum calls before the loop serves its sockets again: some 5 ms of a gateway's work."""


class Crossing:
    """A bounded queue of calls to be made on another thread's loop, in the order given.

    Policy, from half full on: of the heartbeats of one sender only the newest is kept, and of its other messages at most
    `SENDER_ROOM`. The sender is the first argument: an agent or a key. A full queue drops every message. All drops are counted.
    Joining, leaving and subscribing are never dropped: they are few, and their loss would be permanent. They have extra room;
    when that is full, too, the call is refused and nothing has changed.

    Concurrent threads may exceed a bound by one call each. A failing call is counted, and delays no other.

    Args:
        loop: the loop that makes the calls.

    Attributes:
        dropped_heartbeats: heartbeats that a newer one replaced, or that found the queue full.
        dropped_messages: other messages and offers that found the queue, or their sender's part of it, full.
        failures: failed calls, by name.
    """

    def __init__(self, loop: asyncio.AbstractEventLoop) -> None:
        self.dropped_heartbeats = 0
        self.dropped_messages = 0
        self.failures = Failures("a call from another thread")
        self._loop = loop
        self._calls: deque[tuple[Callable[..., object], tuple[Any, ...]]] = deque()
        self._beats: dict[Slot, tuple[Any, ...]] = {}
        """The newest waiting heartbeats beyond `HEARTBEAT_ROOM`, by call, sender and receiver."""
        self._said: Counter[Slot] = Counter()
        """Messages since the queue was half full, by sender and receiver."""
        self._lock = threading.Lock()
        """Guards these two; other shared data changes in one step of the interpreter."""
        self._awake = False

    @property
    def waiting(self) -> int:
        """Number of waiting calls."""
        return len(self._calls)

    def say(self, message: Message, call: Callable[..., object], *args: Any) -> None:
        """Queue a message said by, or on, the first of `args`; dropped when there is no room."""
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
        """Queue a call whose loss is tolerable: it is repeated, or the asker is told.

        Returns:
            False when there is no room: the call will not be made.
        """
        if len(self._calls) >= QUEUE:
            self.dropped_messages += 1
            return False
        self._append(call, args)
        return True

    def order(self, call: Callable[..., object], *args: Any) -> None:
        """Queue a call that must arrive.

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
        """Count one more message of a sender; False when it has too many."""
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
            # The other side has closed its loop: nobody hears anything any more.
            self._calls.clear()
            self._beats.clear()
            self._awake = False

    def _take(self) -> None:
        # First this: a later append wakes us again, so that no call is left behind.
        self._awake = False
        for _ in range(min(CALLS_PER_TURN, len(self._calls))):
            call, args = self._calls.popleft()
            try:
                call(*args)
            except Exception:  # noqa: BLE001 - whatever it is, it is about this one call
                self.failures.note(getattr(call, "__qualname__", type(call).__name__))
        if self._calls and not self._awake:
            self._wake()
