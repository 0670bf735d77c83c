"""The plant's clock in service: the computer's monotonic clock, steered to its unix time.

Agents on several computers share the plant's clock as far as those computers' unix times agree; NTP keeps
them within a few milliseconds, the port asks for 100. But unix time can be set, by a person or by NTP, and
stands still while a virtual computer is moved. Whoever read it directly would stop beating for an hour, or
find all of its deadlines over at once. So what passes here is monotonic time, and what is missing to unix
time, or too much, is made up for by running a tenth faster or slower: no wait ever ends by a step.
"""

from __future__ import annotations

import asyncio
import heapq
import logging
import math
import time
from itertools import count
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable

SLEW_FRAC = 0.1
"""How much faster or slower the clock runs while it is steered. Whoever beats once a second then does so every
1.1 s at most, and three of those are within the 3.5 s after which silence is a failure."""

LOOK_EVERY_S = 1.0
"""Longest wait before unix time is read again, and the longest span over which one reading steers."""

STEP_S = 0.5
"""Unix time that moves by so much against monotonic time from one reading to the next was set. More than a busy
computer lets pass between reading the one and the other."""

_log = logging.getLogger(__name__)


class SystemClock:
    """The plant's time on a running asyncio loop (see `dray.ports.Clock`).

    Args:
        loop: callbacks run on it, and its time is the monotonic one; `call_at` is called on it.
        unix_s: reads the computer's unix time in seconds; for tests.
        speed: seconds of this clock per second; 1 in service, more for a factory with simulated bodies.
        epoch_s: the moment of unix time at which this clock showed the same.

    Attributes:
        steps: how often unix time was set while this clock ran.
        behind_s: what is missing to unix time, in seconds of this clock; below 0 when it is ahead.
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
        self._read_s = loop.time()
        """Monotonic: when the clock was read last."""
        self._shown_s = self._target_s()
        """What it showed then."""
        self.steps = 0
        self.behind_s = 0.0
        # asyncio's own timers do not keep the order of equal times, hence a heap with numbers.
        self._heap: list[tuple[float, int, Callable[[], None]]] = []
        self._numbers = count()
        self._timer: asyncio.TimerHandle | None = None
        self._timer_due_s = math.inf

    def now_s(self) -> float:
        """Seconds; never goes back, and passes a tenth faster or slower than monotonic time at most."""
        read_s = self._loop.time()
        passed_s = (read_s - self._read_s) * self._speed
        missing_s = self._target_s() - (self._shown_s + passed_s)
        moved_s = (missing_s - self.behind_s) / self._speed
        if abs(moved_s) > STEP_S:
            self._tell_step(moved_s)
        most_s = SLEW_FRAC * min(passed_s, LOOK_EVERY_S * self._speed)
        steered_s = min(max(missing_s, -most_s), most_s)
        self._read_s, self._shown_s = read_s, self._shown_s + passed_s + steered_s
        self.behind_s = missing_s - steered_s
        return self._shown_s

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

    def _target_s(self) -> float:
        """What a clock would show that needs no steering."""
        return self._epoch_s + (self._unix_s() - self._epoch_s) * self._speed

    def _tell_step(self, moved_s: float) -> None:
        self.steps += 1
        _log.warning(
            "the computer's clock was set by %+.1f s; the plant's clock follows slowly, and no wait ends by it",
            moved_s,
        )

    def _set_timer(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
        self._timer_due_s = self._heap[0][0]
        # While it catches up it is there sooner; to be woken too early is harmless.
        pace = self._speed * (1.0 + SLEW_FRAC if self.behind_s > 0.0 else 1.0)
        nap_s = min((self._timer_due_s - self.now_s()) / pace, LOOK_EVERY_S)
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
