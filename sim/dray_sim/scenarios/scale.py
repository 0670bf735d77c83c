"""Scale: the same factory floor, larger and larger at equal density; the work of every single agent must stay the same."""

from __future__ import annotations

from dataclasses import dataclass

from dray.messages.keys import STRATEGIST
from dray_sim.bodies.vehicle.odometer import Activity
from dray_sim.plants.generator import generate_plant
from dray_sim.run.evidence import HELD, Check, Table
from dray_sim.run.scenario import Findings, Scenario
from dray_sim.run.stage import Played, Shift, Stage, play

VEHICLES = (8, 50, 200, 1000)

MACHINES_PER_VEHICLE = 0.75
"""The ratio and the floor per vehicle are the same in every plant."""

WARM_UP_S = 900.0
"""Time until orders have become goals, and goals transports."""

SHIFT = Shift(name="scale", duration_s=1800.0, load=0.85)

GROWTH = 1.5
"""Largest work of an agent in the largest plant, as a multiple of that in the plant of `REFERENCE` vehicles. In a
smaller plant all agents are within reach of one another, so there is less to hear. A machine bids for the goals of
the whole plant."""

REFERENCE = 50

AT_WORK = (Activity.MOVING_EMPTY, Activity.MOVING_LOADED, Activity.HANDLING)

LATE_S = 10.0
"""Largest delay of one transport in twenty beyond its promise."""


@dataclass(frozen=True, slots=True)
class Load:
    """Events that agents have handled per second, after the warm-up.

    Attributes:
        vehicle: each of the vehicles, on average.
        machine: each of the machines, on average.
        strategist: which speaks with all machines.
    """

    vehicle: float
    machine: float
    strategist: float


async def work(stage: Stage) -> Load:
    """Let the demand come in, and count the handled events after the warm-up."""
    await stage.until_s(WARM_UP_S)
    before = _handled(stage)
    await stage.until_s(stage.shift.duration_s)
    span_s = stage.shift.duration_s - WARM_UP_S
    spent = {agent: (now - before.get(agent, 0)) / span_s for agent, now in _handled(stage).items()}
    vehicles, machines = stage.factory.vehicles, stage.factory.workcells
    return Load(
        vehicle=sum(spent[atv] for atv in vehicles) / len(vehicles),
        machine=sum(spent[machine] for machine in machines) / len(machines),
        strategist=spent[STRATEGIST],
    )


def _handled(stage: Stage) -> dict[str, int]:
    return {agent: worker.handled for agent, worker in stage.factory.workers.items()}


def grow(
    seed: int, vehicles: tuple[int, ...] = VEHICLES, shift: Shift = SHIFT, reference: int = REFERENCE
) -> Findings:
    """Play one plant of each size, and compare the last with the one of `reference` vehicles."""
    runs = tuple(
        play(shift, generate_plant(seed, round(count * MACHINES_PER_VEHICLE), count), seed, work)
        for count in vehicles
    )
    loads = {count: played.result for count, played in zip(vehicles, runs, strict=True) if played.result}
    base, most = loads.get(reference), loads.get(vehicles[-1])
    growth = (most.vehicle / base.vehicle, most.machine / base.machine) if base and most else (0.0, 0.0)
    late_s = [played.report.late_p95_s for played in runs]
    return Findings(
        runs=runs,
        checks=(
            Check(
                f"From {reference} to {vehicles[-1]} vehicles, an agent has at most {GROWTH:g} times as much to handle",
                all(0.0 < each <= GROWTH for each in growth),
                f"a vehicle {growth[0]:.2f} times, a machine {growth[1]:.2f} times",
            ),
            Check(
                f"19 of 20 transports are at most {LATE_S:.0f} s later than promised, in every plant",
                all(played.invariants == HELD for played in runs) and max(late_s) <= LATE_S,
                ", ".join(f"{each:+.1f} s" for each in late_s),
            ),
        ),
        tables=(
            Table(
                "What grows with the plant, and what does not",
                (
                    "vehicles",
                    "machines",
                    "events/s of a vehicle",
                    "of a machine",
                    "of the strategist",
                    "transports",
                    "p50",
                    "p95",
                    "later than promised p95",
                    "vehicles' time driving and handling",
                    "waiting",
                ),
                tuple(_row(count, played) for count, played in zip(vehicles, runs, strict=True)),
            ),
        ),
    )


def _row(count: int, played: Played[Load]) -> tuple[str, ...]:
    report, load = played.report, played.result
    spent = report.utilisation_frac
    events = (load.vehicle, load.machine, load.strategist) if load else ()
    return (
        f"{count:,}",
        f"{round(count * MACHINES_PER_VEHICLE):,}",
        *(f"{each:.1f}" for each in events or (0.0, 0.0, 0.0)),
        f"{report.transports:,}",
        f"{report.transport_p50_s:.0f} s",
        f"{report.transport_p95_s:.0f} s",
        f"{report.late_p95_s:+.1f} s",
        f"{sum(spent.get(doing, 0.0) for doing in AT_WORK):.1%}",
        f"{spent.get(Activity.WAITING, 0.0):.2%}",
    )


SCALE = Scenario(
    name="scale",
    shows="8, 50, 200 and 1,000 vehicles at equal density: what an agent has to do does not grow.",
    source="paper, 5",
    claim=(
        "Auctions are held between a machine and the vehicles near it, and everybody works out a price of its own. So the number "
        "of machines and vehicles can grow without any agent having more to do."
    ),
    story=(
        f"{SHIFT.duration_s / 60:g} minutes of demand at {SHIFT.load:.0%} load in generated plants with "
        f"{', '.join(f'{count:,}' for count in VEHICLES)} vehicles and {MACHINES_PER_VEHICLE:g} machines for each, on as much floor "
        f"for each. Events are what an agent handles: messages, alarms, what its body tells; counted after {WARM_UP_S / 60:.0f} of them."
    ),
    play=grow,
)
