"""Figures about transports: durations and counts."""

from __future__ import annotations

from collections import deque

from dray.gateway.live.projection.figures.sliding_window import Window

DURATIONS_KEPT = 200
"""Transports used for quantiles: some ten minutes of a plant with 200 vehicles."""

LONGEST_S = 7 * 86_400.0
"""Maximum duration of a transport in seconds; longer or negative ones come from a wrong clock."""

HANDOVER_SLOTS = (15.0, 240)
"""One hour of factory time: slot length in seconds, and number of slots. Twenty slots make five minutes."""

HANDOVER_GROUPS = 12
"""Bars that a panel shows, five minutes each."""


class Transports:
    """Counts transports."""

    def __init__(self) -> None:
        self._opened_s: dict[str, float] = {}
        """Open transports only: bounded like the open tasks, since each is closed or dropped."""
        self._durations_s: deque[float] = deque(maxlen=DURATIONS_KEPT)
        self._sorted_s: list[float] | None = None
        self._handovers = Window(*HANDOVER_SLOTS)
        self._asked = Window(*HANDOVER_SLOTS)
        self.count = 0
        """Transports handed over whose announcement was heard."""

    def opened(self, task: str, at_s: float) -> None:
        """Note a transport's first announcement (plant clock)."""
        self._opened_s[task] = at_s
        self._asked.add(at_s, 1)

    def closed(self, task: str, at_s: float, *, delivered: bool) -> None:
        """Note a transport's end (plant clock)."""
        opened_s = self._opened_s.pop(task, None)
        if delivered and opened_s is not None and 0.0 <= at_s - opened_s <= LONGEST_S:
            self._durations_s.append(at_s - opened_s)
            self._sorted_s = None
            self.count += 1
            self._handovers.add(at_s, 1)

    def forget(self, task: str) -> None:
        """Drop a transport that left the projection before its end."""
        self._opened_s.pop(task, None)

    def quantile_s(self, part: float) -> float | None:
        """Time from announcement to handover within which this fraction of recent transports stayed.

        Args:
            part: 0.5 for the median.
        """
        if not self._durations_s:
            return None
        if self._sorted_s is None:
            self._sorted_s = sorted(self._durations_s)
        # The nearest rank: always a real duration.
        return self._sorted_s[max(0, -int(-part * len(self._sorted_s) // 1) - 1)]

    def carried_frac(self, now_s: float) -> float | None:
        """Transports handed over in the last factory hour, as a fraction of those announced in it.

        None if none was announced.
        """
        (asked,), (carried,) = self._asked.sums(now_s, 1), self._handovers.sums(now_s, 1)
        return min(carried / asked, 1.0) if asked > 0 else None

    def per_hour(self, now_s: float) -> tuple[float, ...]:
        """Handovers per factory hour, in parts of five factory minutes up to now, oldest first."""
        parts = self._handovers.sums(now_s, HANDOVER_GROUPS)
        return tuple(count * HANDOVER_GROUPS for count in parts)
