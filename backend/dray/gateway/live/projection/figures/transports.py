"""Figures about transports: how long they take, and how many there are."""

from __future__ import annotations

from collections import deque

from dray.gateway.live.projection.figures.sliding_window import Window

DURATIONS_KEPT = 200
"""Transports over which quantiles are taken: some ten minutes of a plant with 200 vehicles."""

LONGEST_S = 7 * 86_400.0
"""No transport takes longer, and none ends before it begins: whoever tells of such a one has a wrong clock."""

HANDOVER_SLOTS = (15.0, 240)
"""An hour of factory time: length of a slot in seconds, and how many. Twenty make five minutes."""

HANDOVER_GROUPS = 12
"""Bars that a panel shows, five minutes each."""


class Transports:
    """Counts transports."""

    def __init__(self) -> None:
        self._opened_s: dict[str, float] = {}
        """Open ones only: bounded as the open tasks are, since every opened task is closed or dropped."""
        self._durations_s: deque[float] = deque(maxlen=DURATIONS_KEPT)
        self._sorted_s: list[float] | None = None
        self._handovers = Window(*HANDOVER_SLOTS)
        self._asked = Window(*HANDOVER_SLOTS)
        self.count = 0
        """Handed over, of those whose announcement was heard."""

    def opened(self, task: str, at_s: float) -> None:
        """A transport was announced for the first time (plant clock)."""
        self._opened_s[task] = at_s
        self._asked.add(at_s, 1)

    def closed(self, task: str, at_s: float, *, delivered: bool) -> None:
        """A transport has ended (plant clock)."""
        opened_s = self._opened_s.pop(task, None)
        if delivered and opened_s is not None and 0.0 <= at_s - opened_s <= LONGEST_S:
            self._durations_s.append(at_s - opened_s)
            self._sorted_s = None
            self.count += 1
            self._handovers.add(at_s, 1)

    def forget(self, task: str) -> None:
        """A transport left the projection before its end."""
        self._opened_s.pop(task, None)

    def quantile_s(self, part: float) -> float | None:
        """Time from announcement to handover that this part of the last transports kept to.

        Args:
            part: 0.5 for the median.
        """
        if not self._durations_s:
            return None
        if self._sorted_s is None:
            self._sorted_s = sorted(self._durations_s)
        # The nearest rank: always a duration that really was.
        return self._sorted_s[max(0, -int(-part * len(self._sorted_s) // 1) - 1)]

    def carried_frac(self, now_s: float) -> float | None:
        """Transports handed over in the last factory hour, as a part of those announced in it; None for none."""
        (asked,), (carried,) = self._asked.sums(now_s, 1), self._handovers.sums(now_s, 1)
        return min(carried / asked, 1.0) if asked > 0 else None

    def per_hour(self, now_s: float) -> tuple[float, ...]:
        """Handovers per factory hour, in parts of five factory minutes up to now, oldest first."""
        parts = self._handovers.sums(now_s, HANDOVER_GROUPS)
        return tuple(count * HANDOVER_GROUPS for count in parts)
