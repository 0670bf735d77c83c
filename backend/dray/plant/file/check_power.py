"""Faults of the chargers of a plant: too weak ones let vehicles run flat, or never work, under any demand.

Vehicles stop working in time for the way to a charger and for the queue there (`dray.plant.charger_queue`). Two
conditions make that impossible: the vehicles' consumption without any work exceeds the chargers' power, or the queue
takes more than a battery holds.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import ceil

from dray.errors import NoWay
from dray.plant.charger_queue import WORTH_FRAC, ChargerQueue
from dray.plant.file.reasons import Reason, counted
from dray.plant.plant import Plant
from dray.plant.restrictions import OPEN

FIELD = "chargers"

LARGER = 1.1
"""Batteries are tried in steps of this factor, when it is asked how large they must be."""

FAR_TIMES, SLOW_MPS = 2.0, 0.3
"""Way, in lengths of the floor, and speed at which a battery that suffices needs no further check."""

MOST_TIMES = 50.0
"""Largest multiple of a battery that is given as advice."""


def power_faults(plant: Plant) -> Iterator[tuple[str, str]]:
    """Why its chargers cannot feed its vehicles, as (field, reason); nothing for a plant whose chargers can.

    Args:
        plant: without other faults.
    """
    count, vehicles = len(plant.chargers), len(plant.fleet)
    chargers = Reason(
        "chargers_for",
        chargers=counted("chargers_one", "chargers_many", count),
        vehicles=counted("vehicles_one", "vehicles_many", vehicles),
    )
    needed = chargers_for_idle(plant)
    if needed > count:
        yield FIELD, Reason("idle_energy", chargers=chargers, times=needed / count, count=ceil(needed))
        return
    queue = plant.charger_queue
    short = _short(plant, queue)
    if short:
        yield (
            FIELD,
            Reason("charger_wait", chargers=chargers, type=short, wait_s=queue.wait_s, remedy=_remedy(plant)),
        )


def chargers_for_idle(plant: Plant) -> float:
    """Chargers that are in use all the time when all vehicles only stand."""
    kinds = [plant.vehicle_types[spec.type] for spec in plant.fleet.values()]
    return sum(kind.idle_w / (kind.charge_w + kind.idle_w) for kind in kinds)


def most_needed_frac(plant: Plant, queue: ChargerQueue, kind: str) -> float:
    """Highest battery level that a type needs at the end of a transport: at the place that is farthest from chargers."""
    routes = plant.routes(kind, OPEN)
    most_frac = queue.needed_frac(kind, 0.0, 0.0)
    for place in (*plant.machines, *plant.storages, *plant.warehouses):
        node = plant.node_of(place)
        try:
            _, way = routes.nearest(node, plant.closest(node, plant.chargers, 1))
        except NoWay:
            continue  # It is reported as a trap, where it matters.
        most_frac = max(most_frac, queue.needed_frac(kind, way.length_m, way.duration_s))
    return most_frac


def _short(plant: Plant, queue: ChargerQueue) -> str:
    """A type of the fleet whose battery is too small for the queue; empty where there is none."""
    for kind in sorted({spec.type for spec in plant.fleet.values()}):
        if kind in queue.starved:
            return kind
        up_to_frac = plant.vehicle_types[kind].charging.up_to_frac
        far_m = FAR_TIMES * plant.diameter_m
        if queue.needed_frac(kind, far_m, far_m / SLOW_MPS) + WORTH_FRAC <= up_to_frac:
            continue
        if most_needed_frac(plant, queue, kind) + WORTH_FRAC > up_to_frac:
            return kind
    return ""


def _remedy(plant: Plant) -> tuple[Reason, ...]:
    """The sufficient changes."""
    found: list[Reason] = []
    for chargers in range(len(plant.chargers) + 1, len(plant.fleet) + 1):
        if not _short(plant, ChargerQueue(plant, chargers=chargers)):
            found.append(Reason("remedy_chargers", count=chargers))
            break
    times = LARGER
    while times <= MOST_TIMES:
        if not _short(plant, ChargerQueue(plant, battery=times)):
            found.append(Reason("remedy_batteries", times=times))
            break
        times *= LARGER
    return (*found, Reason("remedy_charge"))
