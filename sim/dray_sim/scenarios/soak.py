"""A month without a stop: whether anything grows that should not."""

from __future__ import annotations

import gc
import resource
import sys
from dataclasses import dataclass
from itertools import pairwise

from dray_sim.evidence import Check, Table
from dray_sim.generator import generate_plant
from dray_sim.scenario import Findings, Scenario
from dray_sim.stage import Shift, Stage, play

DAY_S = 86_400.0
DAYS = 30

MACHINES, VEHICLES, LOAD = 2, 3, 0.2
"""Small, so that a month takes minutes: time makes leaks, not size. Some 50 transports a day."""

FULL_AFTER_DAYS = 10
"""By then every bounded history is full, and the heap has its shape."""

GROWTH_FRAC = 0.05
"""From there to the end; a leak of one small object per transport would be about as much."""


@dataclass(frozen=True, slots=True)
class Day:
    """Sums at the end of a day."""

    transports: int
    orders: int
    blocks: int
    """Living memory blocks of the interpreter."""
    rss_mb: float
    """The most that the process ever held."""


async def month(stage: Stage, days: int) -> tuple[Day, ...]:
    """Live day by day; every day another agent is restarted, so that lives leave nothing behind either."""
    agents = [*stage.factory.workcells, *stage.factory.vehicles]
    seen: list[Day] = []
    for number in range(days):
        await stage.until_s((number + 0.5) * DAY_S)
        stage.factory.restart(agents[number % len(agents)])
        await stage.until_s((number + 1.0) * DAY_S)
        gc.collect()
        seen.append(
            Day(
                transports=len(stage.observer.transports),
                orders=len(stage.observer.fulfilled_s),
                blocks=sys.getallocatedblocks(),
                rss_mb=resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024,
            )
        )
    return tuple(seen)


def soak(seed: int, days: int = DAYS, full_after_days: int = FULL_AFTER_DAYS) -> Findings:
    """Play a month."""
    shift = Shift(name="soak", duration_s=days * DAY_S, load=LOAD)
    played = play(shift, generate_plant(seed, MACHINES, VEHICLES), seed, lambda stage: month(stage, days))
    told = played.told
    if told is None:
        return Findings(runs=(played,), checks=())
    full, last = told[full_after_days - 1], told[-1]
    growth_frac = last.blocks / full.blocks - 1.0
    weeks = [told[first : first + 7] for first in range(0, days, 7)]
    made = [
        days_of[-1].transports - (told[7 * i - 1].transports if i else 0) for i, days_of in enumerate(weeks)
    ]
    report = played.report
    return Findings(
        runs=(played,),
        checks=(
            Check(
                f"Memory is flat: less than {GROWTH_FRAC:.0%} more at the end than on day {full_after_days}",
                growth_frac < GROWTH_FRAC,
                "within that" if growth_frac < GROWTH_FRAC else f"{growth_frac:+.1%}",
            ),
            Check(
                "The last day does as much as the first: work goes on every day",
                all(later.transports > before.transports for before, later in pairwise(told)),
                f"{report.transports} transports in {days} days",
            ),
            Check(
                "At least 99 % of the orders that were due are delivered, and on time",
                report.on_time_frac >= 0.99,
                f"{report.on_time_frac:.1%} of {report.orders_due}",
            ),
        ),
        tables=(
            Table(
                "Transports by week",
                ("week", "transports a day"),
                tuple((str(i + 1), f"{made[i] / len(weeks[i]):.1f}") for i in range(len(weeks))),
            ),
        ),
        measured={
            "memory blocks": ", ".join(
                f"day {d}: {told[d - 1].blocks:,}" for d in _days(days, full_after_days)
            ),
            "growth": f"{growth_frac:+.2%} from day {full_after_days} to day {days}",
            "process": ", ".join(
                f"day {d}: {told[d - 1].rss_mb:.0f} MB" for d in _days(days, full_after_days)
            ),
        },
    )


def _days(days: int, full_after_days: int) -> list[int]:
    """Which days to name."""
    return sorted({1, full_after_days, (full_after_days + days) // 2, days})


SOAK = Scenario(
    name="soak",
    shows="30 virtual days: flat memory, steady work.",
    source="ours; the paper plans long tests, 5",
    claim="The factory works for a month without a stop, and needs no more memory at the end than in between.",
    story=(
        f"{DAYS} days of demand at {LOAD:.0%} load in a plant of {MACHINES} machines and {VEHICLES} vehicles, small so that "
        "it takes minutes. Every day another agent is restarted."
    ),
    play=soak,
)
