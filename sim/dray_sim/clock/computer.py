"""The clock of one agent's computer in the simulation: right, until somebody sets it wrong.

An agent lives on the plant's clock as its computer shows it. In service that clock is monotonic and follows the
computer's unix time by at most a tenth faster or slower (`dray.adapters.system_clock`). This one does the same. After
a step of unix time it drifts towards it; a process that is started meanwhile begins with the present unix time.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Callable
from itertools import count

from dray.adapters.system_clock import SLEW_FRAC
from dray.ports import Clock

ROUNDING_S = 1e-9
"""Rounding of a conversion between two clocks; a nearer time counts as reached."""


class ComputerClock:
    """Implements `dray.ports.Clock`; costs nothing as long as it is right.

    Args:
        plant: the right time.

    Attributes:
        now_s, call_at: see `dray.ports.Clock`.
    """

    __slots__ = (
        "_heap",
        "_numbers",
        "_offset_s",
        "_plant",
        "_shown_s",
        "_since_s",
        "_target_s",
        "_turn",
        "call_at",
        "now_s",
    )

    def __init__(self, plant: Clock) -> None:
        self._plant = plant
        self._since_s = 0.0
        """When, by the right time, `_offset_s` was so."""
        self._offset_s = self._target_s = 0.0
        """Its lead over the right time, and the lead of the computer's unix time."""
        self._shown_s = -math.inf
        """Last time shown to the present process: it never goes back."""
        self._heap: list[tuple[float, int, Callable[[], None]]] = []
        self._numbers = count()
        self._turn = 0
        """Grows when the next call is asked for anew, so that an outdated one is recognised."""
        self.now_s: Callable[[], float] = plant.now_s
        self.call_at: Callable[[float, Callable[[], None]], None] = plant.call_at

    @property
    def ahead_s(self) -> float:
        """Its present lead over the right time."""
        passed_s = self._plant.now_s() - self._since_s
        most_s = SLEW_FRAC * passed_s
        missing_s = self._target_s - self._offset_s
        return self._offset_s + min(max(missing_s, -most_s), most_s)

    def step(self, by_s: float) -> None:
        """Somebody sets the computer's unix time forward, or back if negative."""
        self._note(self.ahead_s, self._target_s + by_s)

    def begin_life(self) -> None:
        """A process is started: it begins with the computer's unix time. Calls of the earlier process are dropped."""
        if self._target_s or self.ahead_s:
            self._heap.clear()
            self._shown_s = -math.inf
            self._note(self._target_s, self._target_s)

    def _note(self, offset_s: float, target_s: float) -> None:
        self._since_s, self._offset_s, self._target_s = self._plant.now_s(), offset_s, target_s
        self.now_s, self.call_at = self._now_s, self._call_at
        self._arm()

    def _now_s(self) -> float:
        self._shown_s = max(self._shown_s, self._plant.now_s() + self.ahead_s)
        return self._shown_s

    def _call_at(self, when_s: float, callback: Callable[[], None]) -> None:
        if when_s == math.inf:
            return
        entry = (max(when_s, self._now_s()), next(self._numbers), callback)
        heapq.heappush(self._heap, entry)
        if self._heap[0] is entry:
            self._arm()

    def _arm(self) -> None:
        self._turn += 1
        if self._heap:
            turn = self._turn
            self._plant.call_at(self._right_s(self._heap[0][0]), lambda: self._run(turn))

    def _right_s(self, when_s: float) -> float:
        """The right time at which this clock shows `when_s`."""
        now_s, ahead_s = self._plant.now_s(), self.ahead_s
        left_s, missing_s = when_s - now_s - ahead_s, self._target_s - ahead_s
        pace = 1.0 + math.copysign(SLEW_FRAC, missing_s) if missing_s else 1.0
        drifts_s = abs(missing_s) / SLEW_FRAC
        if left_s <= drifts_s * pace:
            return now_s + left_s / pace
        return now_s + left_s - missing_s

    def _run(self, turn: int) -> None:
        if turn != self._turn:
            return
        now_s = self._now_s()
        due: list[Callable[[], None]] = []
        while self._heap and self._heap[0][0] <= now_s + ROUNDING_S:
            when_s, _, callback = heapq.heappop(self._heap)
            self._shown_s = max(self._shown_s, when_s)
            due.append(callback)
        self._arm()
        for callback in due:
            callback()
