"""Urgent orders beside others: how much sooner they come, their cost to the others, and that nothing starves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from random import Random

from dray.plant import Plant, default_plant
from dray.priorities import LOW_STANDS_BACK_S, Priority
from dray_sim.checks.passing import Passing
from dray_sim.people.demand import Order, orders
from dray_sim.run.evidence import Check, Table
from dray_sim.run.observer import percentile
from dray_sim.run.scenario import Findings, Scenario
from dray_sim.run.site import Site
from dray_sim.run.stage import Played, Shift, Stage, play

SHIFT = Shift(name="priorities", duration_s=6 * 3600.0)

LOAD = 0.85

SHARES = {Priority.URGENT: 0.1, Priority.HIGH: 0.1, Priority.LOW: 0.1}
"""Parts of the orders; the rest are normal. Only few orders may be urgent: if all are, none is."""

SETTLE_S = LOW_STANDS_BACK_S + 4 * 3600.0
"""Longest time from the last order to the last delivery: a low order is wanted a shift after it is due."""

SOONER_FRAC = 0.75
"""Longest time of an urgent order, relative to its time without priorities. It includes the slowest ones: nothing is
made and brought within 15 minutes."""

COST_FRAC = 0.25
"""Largest extra time of normal orders, as a fraction."""

PASSED_MAX_S = 1800.0
"""Longest time in which a machine goes on with later work: the time to fetch the material of the work that should go
first."""


@dataclass(frozen=True, slots=True)
class Result:
    """Observations of the script.

    Attributes:
        took_s: from placing to the last piece, by delivered order.
        late: those that came after they were due.
        open: orders that were not delivered.
        passing: how long goals were passed.
    """

    took_s: dict[str, float]
    late: frozenset[str]
    open: tuple[str, ...]
    passing: Passing


def demand(plant: Plant, seed: int, load: float, until_s: float) -> list[Order]:
    """A day's orders, each with a priority."""
    random = Random(f"{seed} priorities")
    placed = []
    for order in orders(plant, Random(f"{seed} demand"), load=load, until_s=until_s):
        drawn, priority = random.random(), Priority.NORMAL
        for each, share in SHARES.items():
            if 0 <= drawn < share:
                priority = each
            drawn -= share
        placed.append(replace(order, priority=priority))
    return placed


async def day(stage: Stage, wanted: Sequence[Order]) -> Result:
    """Place them all at their times, and wait until they are delivered."""
    passing = Passing()
    stage.listeners.add(passing)
    for order in wanted:
        await stage.until_s(order.at_s)
        stage.place(order)
    await stage.settle(SETTLE_S)
    done = stage.observer.fulfilled_s
    return Result(
        took_s={order.id: done[order.id] - order.at_s for order in wanted if order.id in done},
        late=frozenset(order.id for order in wanted if done.get(order.id, order.due_s + 1) > order.due_s),
        open=tuple(order.id for order in stage.undelivered()),
        passing=passing,
    )


def compared(seed: int, shift: Shift = SHIFT, load: float = LOAD, plant: Plant | None = None) -> Findings:
    """Play a day with priorities, and the same orders without."""
    plant = plant or default_plant()
    wanted = demand(plant, seed, load, shift.duration_s)
    alike = [replace(order, priority=Priority.NORMAL) for order in wanted]
    hurried, plain = _played(shift, plant, seed, wanted), _played(shift, plant, seed, alike)
    if hurried.result is None or plain.result is None:
        return Findings(runs=(hurried, plain), checks=())
    of = {each: [order.id for order in wanted if order.priority is each] for each in reversed(Priority)}
    everything = [order.id for order in wanted]
    sooner, before = (_p95(result, of[Priority.URGENT]) for result in (hurried.result, plain.result))
    dearer, cheaper = (_mean(result, of[Priority.NORMAL]) for result in (hurried.result, plain.result))
    passing = hurried.result.passing
    return Findings(
        runs=(hurried, plain),
        checks=(
            Check(
                f"An urgent order takes at most {SOONER_FRAC:.0%} of the time that it takes without priorities (p95)",
                sooner <= SOONER_FRAC * before,
                f"{_minutes(sooner)} instead of {_minutes(before)}",
            ),
            Check(
                f"That costs normal orders at most {COST_FRAC:.0%} of their time (mean)",
                dearer <= (1 + COST_FRAC) * cheaper,
                f"{_minutes(dearer)} instead of {_minutes(cheaper)}",
            ),
            Check(
                "Everything is delivered, what is low too",
                not hurried.result.open,
                f"{len(hurried.result.took_s)} of {len(wanted)}",
            ),
            Check(
                f"From its wanted time on nothing is passed for longer than {PASSED_MAX_S / 60:.0f} minutes by what came later",
                passing.longest_s <= PASSED_MAX_S,
                f"{passing.longest_s:.0f} s at most{f' ({passing.longest})' if passing.longest else ''}",
            ),
        ),
        tables=(
            Table(
                "From placing to the last piece, with priorities and without",
                (
                    *("", "orders", "p50", "without", "p95", "without"),
                    *("longest", "without", "late", "without"),
                ),
                (
                    *(_row(str(priority), orders, hurried, plain) for priority, orders in of.items()),
                    _row("all", everything, hurried, plain),
                ),
            ),
        ),
    )


def _played(shift: Shift, plant: Plant, seed: int, wanted: Sequence[Order]) -> Played[Result]:
    return play(shift, plant, seed, lambda stage: day(stage, wanted))


def _row(name: str, of: Sequence[str], hurried: Played[Result], plain: Played[Result]) -> tuple[str, ...]:
    cells = [name, str(len(of))]
    both = [result for result in (hurried.result, plain.result) if result is not None]
    for frac in (0.5, 0.95, 1.0):
        cells += [_minutes(percentile(_took(result, of), frac)) for result in both]
    return (*cells, *(str(len(result.late.intersection(of))) for result in both))


def _took(result: Result, of: Sequence[str]) -> list[float]:
    return [result.took_s[order] for order in of if order in result.took_s]


def _p95(result: Result, of: Sequence[str]) -> float:
    return percentile(_took(result, of), 0.95)


def _mean(result: Result, of: Sequence[str]) -> float:
    took_s = _took(result, of)
    return sum(took_s) / max(1, len(took_s))


def _minutes(span_s: float) -> str:
    return f"{span_s / 60:.0f} min"


def _elsewhere(seed: int, site: Site) -> Findings:
    return compared(seed, site.shift(SHIFT), LOAD if site.load is None else site.load, site.ground)


PRIORITIES = Scenario(
    name="priorities",
    shows="Urgent orders beside others at 85 % load: how much sooner they come, what it costs the others, that nothing starves.",
    source="ours; the paper has no priorities",
    claim=(
        "A priority is a time: agents sort and price their work by when it is wanted, and nobody edits anybody's queue. What is urgent "
        "comes sooner at the cost of what can wait, and from its wanted time on nothing is passed by what came later."
    ),
    story=(
        f"{SHIFT.duration_s / 3600:.0f} hours of orders at {LOAD:.0%} load in the default plant, of which {SHARES[Priority.URGENT]:.0%} are urgent, "
        f"{SHARES[Priority.HIGH]:.0%} high and {SHARES[Priority.LOW]:.0%} low; beside them the same orders, all of them normal."
    ),
    play=compared,
    elsewhere=_elsewhere,
)
