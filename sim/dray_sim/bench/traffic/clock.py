"""Continuous virtual time for a lean world: a heap of timed calls, and nothing else."""

from __future__ import annotations

import heapq
from collections.abc import Callable
from itertools import count
from typing import Any


class LeanClock:
    """Calls in the order of their times, then in the order in which they were asked for.

    Attributes:
        now_s: virtual time.
    """

    def __init__(self) -> None:
        self.now_s = 0.0
        self._heap: list[tuple[float, int, Callable[..., None], tuple[Any, ...]]] = []
        self._numbers = count()

    def call_at(self, when_s: float, call: Callable[..., None], *args: Any) -> None:
        """Call it then; at once if that is past."""
        heapq.heappush(self._heap, (max(when_s, self.now_s), next(self._numbers), call, args))

    def run(self, until_s: float) -> None:
        """Let time pass."""
        heap = self._heap
        while heap and heap[0][0] <= until_s:
            self.now_s, _, call, args = heapq.heappop(heap)
            call(*args)
        self.now_s = until_s
