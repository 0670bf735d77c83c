"""The plant's clock in service: the computer's monotonic clock, steered to its unix time.

Agents on several computers share the plant's clock as far as those computers' unix times agree. NTP keeps them within a few
milliseconds; the port asks for 100. But a person or NTP may set unix time, and it stands still while a virtual computer is
moved. An agent that read it directly would send no heartbeat for an hour, or find all its deadlines over at once. So this
clock follows monotonic time, and removes its difference to unix time by running a tenth faster or slower: no
wait ever ends by a step.
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
"""Relative change of speed while the clock is steered. A heartbeat of once a second then comes every 1.1 s at most.
Three of those are within the 3.5 s of the failure detector."""

LOOK_EVERY_S = 1.0
"""Longest wait before unix time is read again, and the longest time for which one reading steers."""

STEP_S = 0.5
"""A change of unix time against monotonic time between two readings that means that it was set. A busy computer lets less
time pass between the two reads."""

_log = logging.getLogger(__name__)


class SystemClock:
    """The plant's time on a running asyncio loop (see `dray.ports.Clock`).

    Args:
        loop: the loop of the callbacks, and the source of monotonic time; `call_at` must be called on it.
        unix_s: reads the computer's unix time in seconds; for tests.
        speed: seconds of this clock per second; 1 in service, more for a factory with simulated bodies.
        epoch_s: the unix time at which this clock showed the same.

    Attributes:
        steps: number of times that unix time was set while this clock ran.
        behind_s: the lag behind unix time, in seconds of this clock; below 0 when it is ahead.
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
        """Monotonic time of the last reading."""
        self._shown_s = self._target_s()
        """This clock's time at that reading."""
        self.steps = 0
        self.behind_s = 0.0
        # asyncio's own timers do not keep the order of equal times, hence a heap with numbers.
        self._heap: list[tuple[float, int, Callable[[], None]]] = []
        self._numbers = count()
        self._timer: asyncio.TimerHandle | None = None
        self._timer_due_s = math.inf

    def now_s(self) -> float:
        """Seconds; never goes back, and differs from monotonic time by a tenth of its speed at most."""
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
        """Call back at `when_s`; a past time means as soon as possible, infinity means never.

        Raises:
            ValueError: `when_s` is not a number.
        """
        if math.isnan(when_s):
            raise ValueError(f"call_at: the time for {callback!r} is not a number")
        if when_s == math.inf:
            return
        # A past time counts as now; otherwise it would overtake earlier requests.
        when_s = max(when_s, self.now_s())
        heapq.heappush(self._heap, (when_s, next(self._numbers), callback))
        if when_s < self._timer_due_s:
            self._set_timer()

    def _target_s(self) -> float:
        """The time of a clock without steering."""
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
        # While it catches up it gets there sooner; waking too early is harmless.
        pace = self._speed * (1.0 + SLEW_FRAC if self.behind_s > 0.0 else 1.0)
        nap_s = min((self._timer_due_s - self.now_s()) / pace, LOOK_EVERY_S)
        self._timer = self._loop.call_later(max(0.0, nap_s), self._run_due)

    def _run_due(self) -> None:
        self._timer, self._timer_due_s = None, math.inf
        # Only calls due at the start: a callback that asks for "now" must not block the loop.
        due = (self.now_s(), next(self._numbers))
        try:
            while self._heap and self._heap[0][:2] < due:
                _, _, callback = heapq.heappop(self._heap)
                callback()
        finally:
            if self._heap and self._heap[0][0] < self._timer_due_s:
                self._set_timer()
