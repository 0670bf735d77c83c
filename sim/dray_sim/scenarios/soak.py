"""A month without a stop: whether anything grows that should not."""

from __future__ import annotations

import gc
import resource
import sys
from dataclasses import dataclass
from itertools import pairwise

from dray_sim.plants.generator import generate_plant
from dray_sim.run.evidence import Check, Table
from dray_sim.run.observer import percentile
from dray_sim.run.scenario import Findings, Scenario
from dray_sim.run.stage import Shift, Stage, play

DAY_S = 86_400.0
DAYS = 30

MACHINES, VEHICLES, LOAD = 2, 3, 0.2
"""Small, so that a month takes minutes: time makes leaks, not size. Some 50 transports a day."""

FULL_AFTER_DAYS = 10
"""Time until every bounded history is full, and the heap has its shape."""

GROWTH_FRAC = 0.02
"""Largest growth from there to the end. A leak of two small objects per transport would be more."""

SLOWER_FRAC = 0.1
"""Chance has it that one week asks for more transports than another, and these are a little slower."""

WEEK = 7


@dataclass(frozen=True, slots=True)
class Day:
    """Sums at the end of a day."""

    transports: int
    blocks: int
    """Living memory blocks of the interpreter."""
    rss_mb: float
    """The most that the process ever held."""


@dataclass(frozen=True, slots=True)
class Week:
    """The transports of a week, or of the last, incomplete one."""

    a_day: float
    p50_s: float
    p95_s: float

    def row(self, number: int) -> tuple[str, ...]:
        """A row of the table."""
        return (str(number), f"{self.a_day:.1f}", f"{self.p50_s:.0f} s", f"{self.p95_s:.0f} s")


@dataclass(frozen=True, slots=True)
class Month:
    """Observations of the script."""

    days: tuple[Day, ...]
    weeks: tuple[Week, ...]


async def month(stage: Stage, days: int) -> Month:
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
                transports=len(stage.observer.took_s),
                blocks=sys.getallocatedblocks(),
                rss_mb=resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024,
            )
        )
    weeks = tuple(_week(stage, seen, first) for first in range(0, days, WEEK))
    await stage.settle(DAY_S)
    return Month(tuple(seen), weeks)


def _week(stage: Stage, days: list[Day], first: int) -> Week:
    last = min(first + WEEK, len(days))
    begun = days[first - 1].transports if first else 0
    took_s = stage.observer.took_s[begun : days[last - 1].transports]
    return Week(len(took_s) / (last - first), percentile(took_s, 0.5), percentile(took_s, 0.95))


def soak(seed: int, days: int = DAYS, full_after_days: int = FULL_AFTER_DAYS) -> Findings:
    """Play a month."""
    shift = Shift(name="soak", duration_s=days * DAY_S, load=LOAD)
    played = play(shift, generate_plant(seed, MACHINES, VEHICLES), seed, lambda stage: month(stage, days))
    if played.result is None:
        return Findings(runs=(played,), checks=())
    told, weeks = played.result.days, played.result.weeks
    full, last = told[full_after_days - 1], told[-1]
    growth_frac = last.blocks / full.blocks - 1.0
    first_s, last_s = weeks[0].p50_s, weeks[-1].p50_s
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
                "Work goes on every day",
                all(
                    later.transports > before.transports
                    for before, later in pairwise((Day(0, 0, 0.0), *told))
                ),
                f"{last.transports} transports in {days} days",
            ),
            Check(
                f"A transport takes as long in the last week as in the first, within {SLOWER_FRAC:.0%}",
                abs(last_s / first_s - 1.0) <= SLOWER_FRAC if first_s else False,
                f"p50 {first_s:.0f} s, then {last_s:.0f} s",
            ),
            Check(
                "Every order is delivered in the end",
                report.orders_delivered == report.orders_placed,
                f"{report.orders_delivered} of {report.orders_placed}",
            ),
        ),
        tables=(
            Table(
                "Transports by week",
                ("week", "a day", "p50", "p95"),
                tuple(week.row(number) for number, week in enumerate(weeks, 1)),
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
    """The days to name."""
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
