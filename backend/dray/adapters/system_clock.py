"""The plant's clock in service: the computer's unix time, kept from going back.

Agents on several computers share it as far as those computers' clocks agree; NTP keeps them within a
few milliseconds, the port asks for 100.
"""

from __future__ import annotations

import asyncio
import heapq
import math
import time
from itertools import count
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable

MAX_NAP_S = 10.0
"""Longest wait before the time is read again: somebody may set the computer's clock forward, and what
has become due by that must not wait for longer than this."""


class SystemClock:
    """Unix time on a running asyncio loop (see `dray.ports.Clock`).

    When the computer's clock is set back, this one stands until the computer's has caught up.

    Args:
        loop: callbacks run on it; `call_at` is called on it.
        unix_s: reads the computer's clock in seconds; for tests.
        speed: seconds of this clock per second; 1 in service, more for a factory with simulated bodies.
        epoch_s: the moment of unix time at which this clock showed the same.
    """

    def __init__(
        self,
        loop: asyncio.AbstractEventLoop,
        *,
        unix_s: Callable[[], float] = time.time,
        speed: float = 1.0,
        epoch_s: float = 0.0,
    ) -> None:
        self._loop = loop
        self._unix_s = unix_s
        self._speed, self._epoch_s = speed, epoch_s
        self._last_s = -math.inf
        # asyncio's own timers do not keep the order of equal times, hence a heap with numbers.
        self._heap: list[tuple[float, int, Callable[[], None]]] = []
        self._numbers = count()
        self._timer: asyncio.TimerHandle | None = None
        self._timer_due_s = math.inf

    def now_s(self) -> float:
        """Seconds; never goes back."""
        shows_s = self._epoch_s + (self._unix_s() - self._epoch_s) * self._speed
        self._last_s = max(self._last_s, shows_s)
        return self._last_s

    def call_at(self, when_s: float, callback: Callable[[], None]) -> None:
        """Call back at `when_s`; a time that is past means as soon as possible, infinity means never.

        Raises:
            ValueError: `when_s` is not a number.
        """
        if math.isnan(when_s):
            raise ValueError(f"call_at: the time for {callback!r} is not a number")
        if when_s == math.inf:
            return
        # A time that is past counts as now, or it would overtake what was asked for before.
        when_s = max(when_s, self.now_s())
        heapq.heappush(self._heap, (when_s, next(self._numbers), callback))
        if when_s < self._timer_due_s:
            self._set_timer()

    def _set_timer(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
        self._timer_due_s = self._heap[0][0]
        nap_s = min((self._timer_due_s - self.now_s()) / self._speed, MAX_NAP_S)
        self._timer = self._loop.call_later(max(0.0, nap_s), self._run_due)

    def _run_due(self) -> None:
        self._timer, self._timer_due_s = None, math.inf
        # Only what was due when we began: a callback that asks for "now" must not keep the loop.
        due = (self.now_s(), next(self._numbers))
        try:
            while self._heap and self._heap[0][:2] < due:
                _, _, callback = heapq.heappop(self._heap)
                callback()
        finally:
            if self._heap and self._heap[0][0] < self._timer_due_s:
                self._set_timer()
