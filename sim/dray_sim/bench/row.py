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
        name: of the measurement.
        figure: the measured value.
        unit: of both figures.
        baseline: the same work done in the plainest way, or the requirement.
        baseline_name: describes the baseline.
        target: the aim, or None where only the ratio has a meaning.
        note: other observations of the same run.
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
        """The figure as a multiple of the baseline."""
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
        name: of the measurement.
        times_s: all of them.
        note: by which clock.
        target: the aim (s); None for none.
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
"""Column heads of a table of rows."""


def _number(value: float) -> str:
    return f"{value:,.0f}" if abs(value) >= 100 else f"{value:.3g}"


def rates(
    work: Callable[[], int], baseline: Callable[[], int], repeats: int = REPEATS
) -> tuple[float, float]:
    """Rates per second of the work and of the baseline.

    They take turns, so that other load on the machine affects both alike.

    Args:
        work: does it, and returns how many times.
        baseline: likewise.
        repeats: the best of so many runs of each is taken.
    """
    best = [0.0, 0.0]
    for _ in range(repeats):
        for place, run in enumerate((work, baseline)):
            # Garbage of the run before must not be collected in this one's time.
            gc.collect()
            start_s = time.perf_counter()
            done = run()
            best[place] = max(best[place], done / (time.perf_counter() - start_s))
    return best[0], best[1]
