"""The cost of faults: the same shift without any, with lossy links, and with vehicles that die."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from functools import partial

from dray.plant import Plant, default_plant
from dray_sim.faults import LinkTrouble, PoweredOff
from dray_sim.people.habits import Habits
from dray_sim.run.evidence import Check, Table
from dray_sim.run.scenario import Findings, Scenario
from dray_sim.run.stage import Shift, Stage, play
from dray_sim.scenarios.tally import HEAD, SETTLE_S, Tally, all_delivered, row, run_out, tally

SHIFT = Shift(name="fault-cost", duration_s=4 * 3600.0, load=0.85, people=Habits())
"""Half a day of the scenario `day`, with operators on the floor, who have work only when something fails."""

DIES_EVERY_S = 1800.0

ON_TIME_COST = 0.05
"""Largest fraction of the orders that faults may delay."""


async def lose(stage: Stage, loss_frac: float) -> Tally:
    """Work while a part of all deliveries is lost."""
    stage.faults.begin(LinkTrouble(loss_frac=loss_frac))
    return await run_out(stage)


async def die(stage: Stage) -> Tally:
    """Work while every half hour a vehicle dies; operators bring it back."""
    random = stage.random("deaths")
    vehicles = tuple(stage.factory.vehicles)
    while stage.now_s() + DIES_EVERY_S < stage.shift.duration_s:
        await asyncio.sleep(DIES_EVERY_S)
        # The script does not end the fault: a person has to come.
        stage.faults.begin(PoweredOff(random.choice([atv for atv in vehicles if stage.factory.running(atv)])))
    await stage.until_s(stage.shift.duration_s)
    return tally(stage, await stage.settle(SETTLE_S))


CONDITIONS: tuple[tuple[str, Callable[[Stage], Awaitable[Tally]]], ...] = (
    ("no faults", run_out),
    ("5 % loss", partial(lose, loss_frac=0.05)),
    ("20 % loss", partial(lose, loss_frac=0.20)),
    ("a vehicle dies every 30 min", die),
)
"""The first condition is the baseline of the others."""


def cost(seed: int, shift: Shift = SHIFT, plant: Plant | None = None) -> Findings:
    """Play the same shift under every condition."""
    runs = tuple(play(shift, plant or default_plant(), seed, script) for _, script in CONDITIONS)
    best, *shares = [played.result.on_time_frac if played.result else 0.0 for played in runs]
    costs = [best - share for share in shares]
    return Findings(
        runs=runs,
        checks=(
            all_delivered(runs),
            Check(
                f"No fault costs more than {ON_TIME_COST:.0%} of the orders their time",
                max(costs) <= ON_TIME_COST,
                f"{best:.1%} on time without faults; "
                + ", ".join(f"{0.0 - each * 100:+.1f} points" for each in costs),
            ),
        ),
        tables=(
            Table(
                "The same demand under each condition",
                ("", *HEAD),
                tuple((name, *row(played)) for (name, _), played in zip(CONDITIONS, runs, strict=True)),
            ),
        ),
    )


FAULT_COST = Scenario(
    name="fault-cost",
    shows="On-time share and task time at 0, 5, 20 % loss, and with a vehicle dying every 30 minutes.",
    source="ours; the paper plans to look at it, 5",
    claim="What fails costs some time, and no order.",
    story=(
        f"{SHIFT.duration_s / 3600:g} hours of the default plant at {SHIFT.load:.0%} load with operators on the floor: without "
        "faults, with 5 and with 20 % of all deliveries lost, and with a vehicle that dies every half hour, wherever it "
        "is and whatever it carries, until somebody has brought it back."
    ),
    play=cost,
    elsewhere=lambda seed, site: cost(seed, site.shift(SHIFT), site.ground),
)
