"""Peak season: more work than the fleet can carry, until vehicles join while everything runs (case 2)."""

from __future__ import annotations

import asyncio
from dataclasses import dataclass

from msgspec import structs

from dray.messages import Bid, Reason, Role
from dray.messages.fact import ContractEnded
from dray.plant import Plant, VehicleSpec, default_plant
from dray_sim.run.evidence import Check, Table
from dray_sim.run.observer import percentile
from dray_sim.run.scenario import Findings, Scenario
from dray_sim.run.stage import Shift, Stage, play

FIRST_FLEET = ("ATV2", "ATV4")
"""Two vehicles that can carry everything: fewer than the peak needs."""

JOIN_EVERY_S = 30.0

SPAN_S = 3600.0
"""Measured time, before and after."""

SHIFT = Shift(name="peak-season", duration_s=3.5 * SPAN_S, load=0.85, keep=(Bid, ContractEnded))

FACTOR = 1.2
"""Least growth of the transports with the joining vehicles, relative to the same hour of the same demand without
them. The hour before is no measure: other orders come in it."""

SOON_S = 600.0
"""A joining vehicle has bid by then; whether it is the cheapest is up to the others, too."""


@dataclass(frozen=True, slots=True)
class Hour:
    """The work of the measured time."""

    transports: int
    pieces: int
    p50_s: float
    p95_s: float

    def row(self, when: str, vehicles: int) -> tuple[str, ...]:
        """A row of the table."""
        return (
            when,
            str(vehicles),
            str(self.transports),
            str(self.pieces),
            f"{self.p50_s:.0f} s",
            f"{self.p95_s:.0f} s",
        )


@dataclass(frozen=True, slots=True)
class Season:
    """Observations of the script.

    Attributes:
        first_s: how long each joining vehicle took until its first bid.
        disturbed: transports of the first fleet that did not end by a handover.
        lives: incarnations of all that were there before, other than the first.
    """

    before: Hour
    after: Hour
    first_s: dict[str, float]
    disturbed: tuple[str, ...]
    lives: tuple[str, ...]


def short_fleet() -> tuple[Plant, tuple[VehicleSpec, ...]]:
    """The default plant with a part of its vehicles, and the others."""
    file = default_plant().file
    first = tuple(spec for spec in file.fleet if spec.id in FIRST_FLEET)
    others = tuple(spec for spec in file.fleet if spec.id not in FIRST_FLEET)
    return Plant(structs.replace(file, fleet=first)), others


async def season(stage: Stage, joining: tuple[VehicleSpec, ...], span_s: float) -> Season:
    """Warm up for half a span, measure, let the vehicles join one after another, measure at the end."""
    await stage.until_s(span_s / 2)
    before = await _hour(stage, span_s)
    joined_s: dict[str, float] = {}
    for spec in joining:
        stage.factory.add_vehicle(spec)
        joined_s[spec.id] = stage.now_s()
        await asyncio.sleep(JOIN_EVERY_S)
    await stage.until_s(stage.shift.duration_s - span_s)
    after = await _hour(stage, span_s)
    return Season(before, after, _first_s(stage, joined_s), _disturbed(stage), _lives(stage))


async def _hour(stage: Stage, span_s: float) -> Hour:
    seen = stage.observer
    transports, pieces = len(seen.took_s), sum(seen.delivered.values())
    await asyncio.sleep(span_s)
    took_s = seen.took_s[transports:]
    return Hour(
        len(took_s),
        sum(seen.delivered.values()) - pieces,
        percentile(took_s, 0.5),
        percentile(took_s, 0.95),
    )


def _first_s(stage: Stage, joined_s: dict[str, float]) -> dict[str, float]:
    first_s: dict[str, float] = {}
    for bid in stage.witness.all(Bid):
        if bid.agent in joined_s:
            first_s.setdefault(bid.agent, bid.at_s - joined_s[bid.agent])
    return first_s


def _disturbed(stage: Stage) -> tuple[str, ...]:
    return tuple(
        f"{ended.said.task} {ended.said.reason}"
        for ended in stage.witness.all(ContractEnded)
        if ended.agent in FIRST_FLEET
        and ended.said.role is Role.PRIMARY
        and ended.said.reason != Reason.HANDED_OVER
    )


def _lives(stage: Stage) -> tuple[str, ...]:
    machines = {machine: heard.incarnation for machine, heard in stage.witness.machines.items()}
    atvs = {atv: heard.incarnation for atv, heard in stage.witness.atvs.items()}
    return tuple(agent for agent, life in {**machines, **atvs}.items() if life != 1)


def peak(seed: int, shift: Shift = SHIFT, span_s: float = SPAN_S) -> Findings:
    """Play a season with the joining vehicles, and the same demand without."""
    plant, joining = short_fleet()
    joined = play(shift, plant, seed, lambda stage: season(stage, joining, span_s))
    alone = play(shift, plant, seed, lambda stage: season(stage, (), span_s))
    result, twin = joined.result, alone.result
    if result is None or twin is None:
        return Findings(runs=(joined, alone), checks=())
    with_them, without = result.after, twin.after
    slowest_s = max(result.first_s.values(), default=0.0)
    return Findings(
        runs=(joined, alone),
        checks=(
            Check(
                f"With the joining vehicles at least {FACTOR - 1:.0%} more transports are made than without, in the same time",
                with_them.transports >= FACTOR * without.transports,
                f"{without.transports} without, {with_them.transports} with them",
            ),
            Check(
                "A transport takes less time",
                with_them.p50_s < without.p50_s and with_them.p95_s < without.p95_s,
                f"p50 {without.p50_s:.0f} s without, {with_them.p50_s:.0f} s with them; p95 {without.p95_s:.0f} s, "
                f"{with_them.p95_s:.0f} s",
            ),
            Check(
                f"Every joining vehicle bids by itself within {SOON_S / 60:.0f} minutes",
                len(result.first_s) == len(joining) and slowest_s <= SOON_S,
                f"{len(result.first_s)} of {len(joining)}, the slowest after {slowest_s:.0f} s",
            ),
            Check(
                "No transport of those who were there before is disturbed",
                not result.disturbed,
                ", ".join(result.disturbed) or "all ended by their handover",
            ),
            Check(
                "Nobody is restarted for it",
                not result.lives,
                ", ".join(result.lives) or "every agent is in its first life",
            ),
        ),
        tables=(
            Table(
                f"{span_s / 60:.0f} minutes of the same demand each; the first ones came before anybody joined",
                ("", "vehicles", "transports", "pieces", "p50", "p95"),
                (
                    result.before.row("before", len(FIRST_FLEET)),
                    with_them.row("later, with the joining vehicles", len(FIRST_FLEET) + len(joining)),
                    without.row("the same time, without", len(FIRST_FLEET)),
                ),
            ),
        ),
    )


PEAK_SEASON = Scenario(
    name="peak-season",
    shows="Vehicles join at run time: throughput before and after.",
    source="paper, 4.2 case 2",
    claim=(
        "When there is more to do than usual, it is enough to add vehicles. They take part from the moment they "
        "join, and nobody who is there already notices more than that its transports are made sooner."
    ),
    story=(
        f"The default plant at {SHIFT.load:.0%} load begins with {len(FIRST_FLEET)} of its 8 vehicles. After an hour and "
        f"a half the other six join, one every {JOIN_EVERY_S:.0f} s. Beside it the same demand, and nobody joins."
    ),
    play=peak,
)
