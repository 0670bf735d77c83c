"""One figure of a benchmark, and how a rate is measured."""

from __future__ import annotations

import gc
import time
from collections.abc import Callable
from dataclasses import dataclass

REPEATS = 5
"""The best of five: other work on the machine can only make a run slower."""


@dataclass(frozen=True, slots=True)
class Row:
    """One figure.

    Attributes:
        name: what was measured.
        figure: how much it was; more is better.
        unit: of both figures.
        baseline: the same work done in the plainest way, or what is required.
        baseline_name: what the baseline is.
        target: what we want to reach, or None where only the ratio says something.
    """

    name: str
    figure: float
    unit: str
    baseline: float
    baseline_name: str
    target: float | None = None

    @property
    def ratio(self) -> float:
        """How many times the baseline."""
        return self.figure / self.baseline

    @property
    def met(self) -> bool:
        """True when there is no target, or it was reached."""
        return self.target is None or self.figure >= self.target


def best_rate(work: Callable[[], int], repeats: int = REPEATS) -> float:
    """How often per second `work` does whatever it counts.

    Args:
        work: does it, and returns how many times.
        repeats: the best of so many runs is taken.
    """
    best = 0.0
    for _ in range(repeats):
        # What the run before left behind must not be cleaned up on this one's time.
        gc.collect()
        start_s = time.perf_counter()
        done = work()
        best = max(best, done / (time.perf_counter() - start_s))
    return best
