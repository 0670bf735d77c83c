"""The benefit of reporting and avoiding obstacles: the time that transports lose by obstacles on lanes."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from enum import StrEnum
from functools import partial
from itertools import pairwise

from dray.body import BodyState, Instruction, ProblemCleared, ProblemRaised, Report, WayBlocked, WayFree
from dray.messages import ObstacleSeen, Problem, ProblemKind, Transport
from dray.messages.fact import TaskClosed, TaskOpened
from dray.plant import Plant, default_plant
from dray.plant.model import VehicleSpec
from dray.ports import Body
from dray_sim.bodies.vehicle.vehicle import SimVehicle
from dray_sim.checks.floor.obstacles import MindsObstacles
from dray_sim.faults import FaultError, Faults, LaneBlocked, Thing
from dray_sim.run.evidence import Check, Table
from dray_sim.run.scenario import Findings, Scenario
from dray_sim.run.stage import Played, Shift, Stage, play

SEEDS = 8

SHIFT = Shift(
    name="obstacles", duration_s=3600.0, load=0.6, keep=(TaskOpened, TaskClosed, ObstacleSeen), overlaps=False
)

EVERY_S, LASTS_S = 150.0, (60.0, 300.0)
"""Between two obstacles, in the mean; how long each lies there."""

SETTLE_S = 1800.0


class Reporting(StrEnum):
    """The vehicles' knowledge of obstacles."""

    NONE = "there are none"
    PROBLEM = "a problem of whoever meets them"
    PLACE = "told and gone round"


class _WithoutPlace:
    """A body that reports a blocked way without the place: its agent can only wait until that is over."""

    def __init__(self, body: Body) -> None:
        self._body = body

    def instruct(self, instruction: Instruction) -> None:
        self._body.instruct(instruction)

    def sense(self) -> BodyState:
        return self._body.sense()

    def attach(self, report: Callable[[Report], None]) -> None:
        def tell(said: Report) -> None:
            if isinstance(said, WayBlocked):
                said = ProblemRaised(
                    reason="the way is blocked", problem=Problem(kind=ProblemKind.WAY_BLOCKED)
                )
            elif isinstance(said, WayFree):
                said = ProblemCleared()
            report(said)

        self._body.attach(tell)


def _without_place(_spec: VehicleSpec, vehicle: SimVehicle, _life: int) -> Body:
    return _WithoutPlace(vehicle)


async def obstruct(stage: Stage, reporting: Reporting) -> tuple[float, int, int]:
    """Let things lie on lanes that vehicles are about to drive.

    Returns:
        Mean time from announcement to delivery (s), transports delivered, and obstacles that lay on a lane.
    """
    checks = MindsObstacles(stage.factory)
    if reporting is Reporting.PLACE:
        stage.checks.add(checks)
    gaps, lanes, things = stage.random("gaps"), stage.random("lanes"), stage.random("things")
    laid = 0
    while stage.now_s() < stage.shift.duration_s:
        await asyncio.sleep(gaps.expovariate(1.0 / EVERY_S))
        lasts_s, choice, thing = gaps.uniform(*LASTS_S), lanes.random(), things.choice(tuple(Thing))
        if reporting is Reporting.NONE:
            continue
        ahead = sorted({ends for beat in stage.witness.atvs.values() for ends in pairwise(beat.way)})
        docks = {stage.factory.plant.node_of(place) for place in stage.factory.plant.places}
        free = [ends for ends in ahead if not docks & set(ends)]
        if not free:
            continue
        try:
            fault = stage.faults.begin(LaneBlocked(*free[int(choice * len(free))], thing))
        except FaultError:
            continue
        laid += 1
        stage.factory.clock.call_at(stage.now_s() + lasts_s, partial(_take_away, stage.faults, fault))
    await stage.settle(SETTLE_S)
    # A machine's production is a task as well, takes ten times as long, and does not depend on lanes.
    opened_s = {
        seen.said.task: seen.at_s
        for seen in reversed(stage.witness.all(TaskOpened))
        if isinstance(seen.said.work, Transport)
    }
    took_s = [
        seen.at_s - opened_s[seen.said.task]
        for seen in stage.witness.all(TaskClosed)
        if seen.said.outcome == "delivered" and seen.said.task in opened_s
    ]
    return sum(took_s) / max(len(took_s), 1), len(took_s), laid


def _take_away(faults: Faults, fault: str) -> None:
    """Remove the obstacle, unless it was a person who has gone on already."""
    with suppress(FaultError):
        faults.end(fault)


def obstacles(seed: int, seeds: int = SEEDS, shift: Shift = SHIFT, plant: Plant | None = None) -> Findings:
    """Play the same shift three times with every seed: without obstacles, met as problems, and told and gone round."""
    ground = plant or default_plant()
    runs: dict[Reporting, list[Played[tuple[float, int, int]]]] = {reporting: [] for reporting in Reporting}
    for number in range(seed, seed + seeds):
        for reporting, played in runs.items():
            held = replace(shift, embody=_without_place) if reporting is Reporting.PROBLEM else shift
            played.append(play(held, ground, number, partial(obstruct, reporting=reporting)))
    found = {reporting: [each.result or (0.0, 0, 0) for each in played] for reporting, played in runs.items()}
    mean_s = {
        reporting: sum(took_s for took_s, _, _ in each) / len(each) for reporting, each in found.items()
    }
    lost_s = {reporting: mean_s[reporting] - mean_s[Reporting.NONE] for reporting in Reporting}
    return Findings(
        runs=tuple(each for played in runs.values() for each in played),
        checks=(
            Check(
                "Told and gone round, obstacles cost less time than met as problems",
                lost_s[Reporting.PLACE] < lost_s[Reporting.PROBLEM],
                f"{lost_s[Reporting.PLACE]:.0f} s instead of {lost_s[Reporting.PROBLEM]:.0f} s for each transport",
            ),
            Check(
                "Something lay in the way in every run",
                all(
                    laid
                    for reporting in (Reporting.PROBLEM, Reporting.PLACE)
                    for _, _, laid in found[reporting]
                ),
                f"{sum(laid for _, _, laid in found[Reporting.PLACE])} obstacles in {seeds} runs",
            ),
        ),
        tables=(
            Table(
                "From announcement to delivery",
                ("obstacles are", "obstacles", "transports", "mean", "lost by them"),
                tuple(
                    (
                        reporting.value,
                        str(sum(laid for _, _, laid in each)),
                        str(sum(count for _, count, _ in each)),
                        f"{mean_s[reporting]:.0f} s",
                        f"{lost_s[reporting]:.0f} s",
                    )
                    for reporting, each in found.items()
                ),
            ),
        ),
    )


OBSTACLES = Scenario(
    name="obstacles",
    shows="What pallets, people and doors on lanes cost, met as problems and told and gone round.",
    source="paper, 3.1: vehicles detect obstacles and avoid them; 4.2, case 4",
    claim="What lies on a lane is told by whoever meets it first, and the others go round.",
    story=(
        f"{SEEDS} times {SHIFT.duration_s / 3600:g} h of the default plant at {SHIFT.load:.0%} load. About every {EVERY_S:.0f} s something lies for "
        f"{LASTS_S[0]:.0f} to {LASTS_S[1]:.0f} s on a lane that a vehicle is about to drive; people go on after a minute. "
        "Three times: without, with bodies that can only say that their way is blocked, and with bodies that say where."
    ),
    play=obstacles,
    elsewhere=lambda seed, site: obstacles(seed, 1, site.shift(SHIFT), site.ground),
)
