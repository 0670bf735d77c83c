"""Whether a fleet carries less than a smaller one, or only seems to by chance.

Both fleets are run with the same seeds. The orders of a seed are the same for both, so their *differences* are
compared (a paired t-test), not their means.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from statistics import fmean, stdev
from typing import Literal

import msgspec

MOST_FALL_FRAC = 0.05
"""Throughput should never fall by more than this part as vehicles are added."""

T_99 = (
    31.821, 6.965, 4.541, 3.747, 3.365, 3.143, 2.998, 2.896, 2.821, 2.764, 2.718, 2.681, 2.650, 2.624, 2.602,
    2.583, 2.567, 2.552, 2.539, 2.528, 2.518, 2.508, 2.500, 2.492, 2.485, 2.479, 2.473, 2.467, 2.462, 2.457,
)  # fmt: skip
"""Student's t that chance exceeds once in a hundred times, for 1 to 30 degrees of freedom; the last is used for more.

Once in a hundred, because the best of several smaller fleets is the best partly by chance: with five of them, chance
alone exceeds it at most five times in a hundred."""

Verdict = Literal["holds", "falls", "open"]


class Fall(msgspec.Struct, frozen=True):
    """How much less a fleet carries than a smaller one, as parts of what the smaller one carries.

    Attributes:
        vehicles: size of the smaller fleet.
        frac: the mean difference; below 0 if the larger fleet carries more.
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
    differences = [smaller[best][seed] - carried[seed] for seed in seeds]
    error_frac = standard_error(differences) / most
    chance_frac = math.inf
    if len(seeds) > 1:
        chance_frac = T_99[min(len(seeds) - 1, len(T_99)) - 1] * error_frac
    return Fall(best, fmean(differences) / most, error_frac, chance_frac)
