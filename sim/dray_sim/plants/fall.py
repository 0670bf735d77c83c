"""Whether a fleet carries less than a smaller one, or only seems to by chance.

Both fleets are run with the same seeds. The orders of a seed are the same for both, so their *ratio* is judged run by
run: a seed with much to carry has more transports with any fleet.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from statistics import fmean, stdev
from typing import Literal

import msgspec

MOST_FALL_FRAC = 0.05
"""Throughput should never fall by more than this part as vehicles are added."""

CHANCE = 0.05
"""Most cases in which chance alone is called a fall. They are shared among all smaller fleets, because the best of several
is the best partly by chance."""

ANGLE_ERROR = 1e-12
"""Error of the angle in `student_t` (rad): far below what a table prints."""

Verdict = Literal["holds", "falls", "open"]


class Fall(msgspec.Struct, frozen=True):
    """How much less a fleet carries than a smaller one, as parts of what the smaller one carries.

    Attributes:
        vehicles: size of the smaller fleet.
        frac: the difference of the means; below 0 if the larger fleet carries more.
        error_frac: its standard error; infinite for a single run.
        chance_frac: difference that chance can explain.
    """

    vehicles: int
    frac: float
    error_frac: float
    chance_frac: float

    @property
    def verdict(self) -> Verdict:
        """`falls` if the fall is larger than 5 % and than chance; `holds` if it is at most 5 % even with bad luck."""
        if self.frac > max(MOST_FALL_FRAC, self.chance_frac):
            return "falls"
        return "holds" if self.frac + self.chance_frac <= MOST_FALL_FRAC else "open"

    def tell(self) -> str:
        """The comparison in words."""
        error = f" ± {self.error_frac:.1%}" if math.isfinite(self.error_frac) else ""
        change = "less" if self.frac > 0.0 else "more"
        return f"{self.verdict}: {abs(self.frac):.1%}{error} {change} than {self.vehicles}"


def standard_error(values: Sequence[float]) -> float:
    """The standard error of a mean; infinite for a single value."""
    return stdev(values) / math.sqrt(len(values)) if len(values) > 1 else math.inf


def fall_from_best(smaller: Mapping[int, Mapping[int, float]], carried: Mapping[int, float]) -> Fall | None:
    """Compare a fleet with the smaller one that carries most.

    Args:
        smaller: what smaller fleets carry: by size, and by the seed of the run.
        carried: what this fleet carries, by the seed of the run.

    Returns:
        None if no smaller fleet was run with one of these seeds, or none carries anything.
    """
    best, most, seeds = 0, 0.0, list[int]()
    for size, each in smaller.items():
        shared = sorted(each.keys() & carried.keys())
        if shared and (mean := fmean(each[seed] for seed in shared)) > most:
            best, most, seeds = size, mean, shared
    if not seeds:
        return None
    mean = fmean(carried[seed] for seed in seeds)
    # The error of a ratio: how far each run is from what the ratio of the means says.
    error_frac = standard_error([carried[seed] - mean / most * smaller[best][seed] for seed in seeds]) / most
    chance_frac = math.inf
    if len(seeds) > 1:
        chance_frac = student_t(CHANCE / len(smaller), len(seeds) - 1) * error_frac
    return Fall(best, 1.0 - mean / most, error_frac, chance_frac)


def student_t(chance: float, freedom: int) -> float:
    """Student's t that chance exceeds in this part of all cases.

    Args:
        chance: above 0, and below 0.5.
        freedom: degrees of freedom, at least 1.

    Source: Abramowitz and Stegun, 26.7.3 and 26.7.4, solved by bisection.
    """
    low, high = 0.0, math.pi / 2.0
    while high - low > ANGLE_ERROR:
        middle = (low + high) / 2.0
        low, high = (middle, high) if _exceeds(middle, freedom) > chance else (low, middle)
    return math.sqrt(freedom) * math.tan(low)


def _exceeds(angle: float, freedom: int) -> float:
    """Part of all cases in which t exceeds the root of the degrees of freedom times the tangent of an angle."""
    odd = freedom % 2
    term, total = (math.cos(angle) if odd else 1.0), 0.0
    for power in range(odd, freedom - 1, 2):
        total += term
        term *= math.cos(angle) ** 2 * (power + 1) / (power + 2)
    within = math.sin(angle) * total
    if odd:
        within = (angle + within) * 2.0 / math.pi
    return (1.0 - within) / 2.0
