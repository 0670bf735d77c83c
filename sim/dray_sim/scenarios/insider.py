"""One liar in the fleet: its cost, behaviour by behaviour."""

from __future__ import annotations

import asyncio
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

from dray.plant import Plant, default_plant
from dray_sim.insiders import BEHAVIOURS, Behaviour
from dray_sim.insiders.joining import bring_in
from dray_sim.run.evidence import Check, Table
from dray_sim.run.scenario import Findings, Scenario
from dray_sim.run.stage import Played, Shift, Stage, play

SHIFT = Shift(name="insider", duration_s=8 * 3600.0, load=0.6)

LEARNING_S = 900.0
"""Coordinators learn by their own experience, so the first lies of each cost more; they are not counted."""

COST_FRAC = 0.05
"""Largest fraction of the deliveries that a liar may cost, after the first quarter of an hour."""


LIARS = tuple(behaviour for behaviour in BEHAVIOURS.values() if not behaviour.has_key)
"""A thief of a vehicle's disk costs that vehicle until a person releases it, and no person is there."""


@dataclass(frozen=True, slots=True)
class Deliveries:
    """Deliveries after `LEARNING_S`."""

    orders: int
    pieces: int

    def cost_frac(self, without: Deliveries) -> float:
        """The greater of the losses in orders and in pieces, relative to the same shift without the liar."""
        return max(_lost_frac(self.orders, without.orders), _lost_frac(self.pieces, without.pieces))


async def work(stage: Stage, behaviour: Behaviour | None) -> Deliveries:
    """A shift with an insider, or without any."""
    lives = None
    if behaviour is not None:
        worker = bring_in(stage.factory, behaviour)
        if not behaviour.drives:
            lives = asyncio.create_task(worker.run())
    try:
        await stage.until_s(LEARNING_S)
        begun = _arrived(stage)
        await stage.until_s(stage.shift.duration_s)
        ended = _arrived(stage)
    finally:
        if lives is not None:
            lives.cancel()
    return Deliveries(ended.orders - begun.orders, ended.pieces - begun.pieces)


def _arrived(stage: Stage) -> Deliveries:
    seen = stage.observer
    return Deliveries(len(seen.fulfilled_s), sum(seen.delivered.values()))


def _lost_frac(now: int, before: int) -> float:
    return 1.0 - now / before if before else 0.0


def insider(
    seed: int,
    shift: Shift = SHIFT,
    behaviours: Sequence[Behaviour] = LIARS,
    plant: Plant | None = None,
) -> Findings:
    """Play the same shift without an insider, and with each of them."""
    plant = plant or default_plant()
    without = play(shift, plant, seed, partial(work, behaviour=None))
    runs = [play(shift, plant, seed, partial(work, behaviour=behaviour)) for behaviour in behaviours]
    base = without.result or Deliveries(0, 0)
    costs = {
        behaviour.name: _cost_frac(played, base) for behaviour, played in zip(behaviours, runs, strict=True)
    }
    worst = max(costs, key=lambda name: costs[name])
    return Findings(
        runs=(without, *runs),
        checks=(
            Check(
                f"No liar costs more than {COST_FRAC:.0%} of the deliveries, after the first "
                f"{LEARNING_S / 60:.0f} minutes",
                bool(base.orders) and costs[worst] <= COST_FRAC,
                f"the worst is {worst}: {costs[worst]:.1%}",
            ),
        ),
        tables=(
            Table(
                f"{shift.duration_s / 3600:g} hours of the same demand, without an insider and with each",
                ("", "orders", "pieces", "cost", "transport p50", "p95", "starved"),
                (
                    _row("nobody lies", without, base),
                    *(
                        _row(behaviour.name, played, base)
                        for behaviour, played in zip(behaviours, runs, strict=True)
                    ),
                ),
            ),
        ),
    )


def _cost_frac(played: Played[Deliveries], base: Deliveries) -> float:
    return played.result.cost_frac(base) if played.result is not None else 1.0


def _row(name: str, played: Played[Deliveries], base: Deliveries) -> tuple[str, ...]:
    report, result = played.report, played.result
    return (
        name,
        f"{result.orders}" if result else played.invariants,
        f"{result.pieces}" if result else "-",
        f"{_cost_frac(played, base):.1%}",
        f"{report.transport_p50_s:.0f} s",
        f"{report.transport_p95_s:.0f} s",
        f"{report.starvation_frac:.2%}",
    )


INSIDER = Scenario(
    name="insider",
    shows="A liar in the fleet: what each of its lies costs.",
    source="ours; the paper trusts every agent",
    claim=(
        f"One liar among nine vehicles costs at most {COST_FRAC:.0%} of the deliveries of a shift, once the first "
        f"{LEARNING_S / 60:.0f} minutes are over, however it lies."
    ),
    story=(
        f"{SHIFT.duration_s / 3600:g} hours of the default plant at {SHIFT.load:.0%} load with its eight honest vehicles: "
        "without an insider, which is what they can do, and then once for each behaviour with a ninth vehicle that has a "
        "valid certificate and lies."
    ),
    play=insider,
    elsewhere=lambda seed, site: insider(seed, site.shift(SHIFT), plant=site.ground),
)
