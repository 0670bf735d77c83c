"""Material by way of storages, which vehicles refill, against material straight from the warehouse to the machines."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from dray.plant import Plant, PlantFile, default_plant
from dray_sim.bodies.vehicle.odometer import Activity
from dray_sim.plants.supplied import refilled_by_vehicles, straight_from_the_warehouse
from dray_sim.run.evidence import Check, Table
from dray_sim.run.scenario import Findings, Scenario
from dray_sim.run.stage import Played, Shift, Stage, play
from dray_sim.scenarios.tally import SETTLE_S, all_delivered

SHIFT = Shift(name="supply", duration_s=2 * 3600.0, load=0.6)

WAYS: Mapping[str, Callable[[PlantFile], PlantFile]] = {
    "storages fill themselves": lambda file: file,
    "vehicles refill storages": refilled_by_vehicles,
    "straight from the warehouse": straight_from_the_warehouse,
}


BUSY = (Activity.MOVING_EMPTY, Activity.MOVING_LOADED, Activity.HANDLING, Activity.WAITING)


@dataclass(frozen=True, slots=True)
class Cost:
    """The cost of a way of bringing material.

    Attributes:
        floor_m2: area of the storages.
        vehicles: at work, on average.
        metres_m: driven by all of them.
        energy_wh: used by all of them, driving and standing.
    """

    floor_m2: float
    vehicles: float
    metres_m: float
    energy_wh: float


async def _delivered(stage: Stage) -> Cost:
    """Let the orders come in and be delivered."""
    await stage.until_s(stage.shift.duration_s)
    await stage.settle(SETTLE_S)
    plant = stage.plant
    busy_s = metres_m = energy_wh = 0.0
    for name, vehicle in stage.factory.vehicles.items():
        done, kind = vehicle.odometer(), plant.vehicle_types[plant.fleet[name].type]
        busy_s += sum(done.seconds[each] for each in BUSY)
        metres_m += done.metres_m
        energy_wh += done.empty_m * kind.drive_wh_per_m + done.loaded_m * kind.loaded_wh_per_m
        energy_wh += sum(done.seconds.values()) / 3600.0 * kind.idle_w
    return Cost(
        floor_m2=sum(each.box.width_m * each.box.depth_m for each in plant.file.storages),
        vehicles=busy_s / stage.factory.clock.now_s(),
        metres_m=metres_m,
        energy_wh=energy_wh,
    )


def compared(seed: int, shift: Shift = SHIFT, plant: Plant | None = None) -> Findings:
    """Play the same orders with material brought in each way."""
    file = (plant or default_plant()).file
    runs = tuple(play(shift, Plant(otherwise(file)), seed, _delivered) for otherwise in WAYS.values())
    itself, refilled, straight = (run.report.transports for run in runs)
    return Findings(
        runs=runs,
        checks=(
            all_delivered(runs),
            Check(
                "A way by storages that vehicles refill takes more transports than a straight one, and than a refill by somebody else",
                refilled > max(itself, straight),
                f"{refilled}, against {straight} and {itself}",
            ),
        ),
        tables=(
            Table(
                "The same orders, with material brought in three ways",
                (
                    *("", "storages", "vehicles at work", "transports", "metres", "energy"),
                    *("transport p50", "p95", "starved", "delivered"),
                ),
                tuple(_row(way, run) for way, run in zip(WAYS, runs, strict=True)),
            ),
        ),
    )


def _row(way: str, played: Played[Cost]) -> tuple[str, ...]:
    report, cost = played.report, played.result
    return (
        way,
        "-" if cost is None else f"{cost.floor_m2:.0f} m2",
        "-" if cost is None else f"{cost.vehicles:.1f}",
        f"{report.transports}",
        "-" if cost is None else f"{cost.metres_m:.0f}",
        "-" if cost is None else f"{cost.energy_wh:.0f} Wh",
        f"{report.transport_p50_s:.0f} s",
        f"{report.transport_p95_s:.0f} s",
        f"{report.starvation_frac:.2%}",
        f"{report.orders_delivered} of {report.orders_placed}",
    )


SUPPLY = Scenario(
    name="supply",
    shows="Material by way of storages that vehicles refill, against material straight from the warehouse.",
    source="the paper, section 1 and Figure 1: with many robots the intermediate step can be left out",
    claim=(
        "A storage orders its own refills, and vehicles bring them; where a plant has no storages machines have material fetched in the "
        "warehouse itself. Both are transports as all others, and the same orders are delivered either way."
    ),
    story=(
        f"{SHIFT.duration_s / 3600:.0f} hours of orders at {SHIFT.load:.0%} load in the default plant, three times: with storages that fill "
        "themselves, with storages that vehicles refill, and without storages."
    ),
    play=compared,
    elsewhere=lambda seed, site: compared(seed, site.shift(SHIFT), site.ground),
)
