"""One figure of a benchmark, and how a rate is measured."""

from __future__ import annotations

import gc
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from dray_sim.run.observer import percentile

REPEATS = 5
"""The best of five: other work on the machine can only make a run slower."""


@dataclass(frozen=True, slots=True)
class Row:
    """One figure.

    Attributes:
        name: what was measured.
        figure: how much it was.
        unit: of both figures.
        baseline: the same work done in the plainest way, or what is required.
        baseline_name: what the baseline is.
        target: what we want to reach, or None where only the ratio says something.
        note: what else was seen in the same run.
        less: whether less is better, else more is.
    """

    name: str
    figure: float
    unit: str
    baseline: float
    baseline_name: str
    target: float | None = None
    note: str = ""
    less: bool = False

    @property
    def ratio(self) -> float:
        """How many times the baseline."""
        return self.figure / self.baseline

    @property
    def met(self) -> bool:
        """True when there is no target, or it was reached."""
        if self.target is None:
            return True
        return self.figure <= self.target if self.less else self.figure >= self.target

    @property
    def cells(self) -> tuple[str, ...]:
        """The row as people read it, under `HEADS`."""
        aim = ""
        if self.target is not None:
            aim = f"{'at most ' if self.less else ''}{_number(self.target)} {'met' if self.met else 'MISSED'}"
        figure = f"{_number(self.figure)} {self.unit}"
        return (self.name, figure, f"{self.ratio:.3g} x {self.baseline_name}", aim, self.note)


def tail_row(
    name: str, times_s: Sequence[float], note: str = "of the plant's clock", target: float | None = None
) -> Row:
    """The 95th percentile of some times (s), beside their median.

    Args:
        name: what was measured.
        times_s: all of them.
        note: by which clock.
        target: what is to be reached (s); None for nothing.
    """
    longest_s = max(times_s, default=0.0)
    return Row(
        name,
        percentile(times_s, 0.95),
        "s",
        max(1e-9, percentile(times_s, 0.5)),
        "the median",
        target,
        note=f"{note}; of {len(times_s)}; longest {longest_s:.3g} s",
        less=True,
    )


HEADS = ("benchmark", "figure", "times the baseline", "aim", "")
"""Of a table of rows."""


def _number(value: float) -> str:
    return f"{value:,.0f}" if abs(value) >= 100 else f"{value:.3g}"


def rates(
    work: Callable[[], int], baseline: Callable[[], int], repeats: int = REPEATS
) -> tuple[float, float]:
    """How often per second each of the two does whatever it counts.

    They take turns, so that both have the same share of whatever else the machine is doing.

    Args:
        work: does it, and returns how many times.
        baseline: likewise.
        repeats: the best of so many runs of each is taken.
    """
    best = [0.0, 0.0]
    for _ in range(repeats):
        for place, run in enumerate((work, baseline)):
            # What the run before left behind must not be cleaned up on this one's time.
            gc.collect()
            start_s = time.perf_counter()
            done = run()
            best[place] = max(best[place], done / (time.perf_counter() - start_s))
    return best[0], best[1]
