"""The small plant of one run: generated, with small containers and short cycles, so that transports are frequent."""

from __future__ import annotations

from math import ceil
from random import Random

import msgspec

from dray.plant import (
    MachineSpec,
    Making,
    Material,
    Plant,
    PlantFile,
    Product,
    VehicleSpec,
    VehicleType,
)
from dray.plant.working_time import WeeklySpan, WorkingHours
from dray_sim.explore.doors import with_doors
from dray_sim.explore.levels import with_levels, with_scrap
from dray_sim.explore.profile import Profile
from dray_sim.explore.stations import with_stations
from dray_sim.people import demand
from dray_sim.plants.generator import generate_plant

TRANSPORT_S = 120.0
"""Approximate duration of a transport in a small plant; it limits the demand to the fleet's capacity."""

TWO_LANES_FRAC = 0.5
"""Fraction of the plants with two-lane roads; on single track vehicles hinder one another most."""

BATTERY_SHARE = (0.04, 0.15)
"""Battery size as a fraction of the usual one: it lasts for a quarter of an hour to an hour of driving, and is
charged in six to 25 minutes."""

WORKS_MIN, RESTS_MIN = (2, 8), (1, 5)
"""Minutes from one break to the next, and of a break."""

RESTS_UNTIL_MIN = 120
"""Latest beginning of a break: no run takes so long unless something is wrong."""

OWN_RESTS_FRAC = 0.4
"""Fraction of the machines, and of the operators' areas, with a working time of their own."""

LEAST_LOT = 2
"""Pieces in the smallest container of a run."""


def bearable_load(plant: Plant) -> float:
    """Part of the machines' time at which the whole fleet is busy all the time."""
    busy_frac = 0.0
    for product in map(plant.products.__getitem__, plant.ordered):
        loads = loads_per_piece(plant, product.id)
        busy_frac += loads * TRANSPORT_S / demand.mean_cycle_s(plant, product.id) / len(plant.ordered)
    return len(plant.fleet) / (len(plant.machines) * busy_frac)


def loads_per_piece(plant: Plant, product: str) -> float:
    """Containers that are carried for one piece, those of its parts and of their materials too."""
    made = plant.products[product]
    return 1.0 / made.lot + sum(
        line.quantity * loads_per_piece(plant, line.material)
        if line.material in plant.parts
        else line.quantity * _ways(plant, line.material) / plant.materials[line.material].lot
        for line in made.bill
    )


def _ways(plant: Plant, material: str) -> int:
    """Number of transports of a material until it reaches its machine."""
    refilled = (plant.stores[place].refill == "vehicles" for place in plant.storages_of(material))
    return 2 if any(refilled) else 1


def small_plant(seed: int, ranges: Profile, random: Random) -> Plant:
    """A generated plant whose containers and buffers are small, so that a lot is carried in a short time."""
    machines, vehicles = random.randint(*ranges.machines), random.randint(*ranges.vehicles)
    lot_frac, cycle_frac = random.uniform(*ranges.lot_frac), random.uniform(*ranges.cycle_frac)
    two_lanes = Random(f"{seed} lanes").random() < TWO_LANES_FRAC
    file = generate_plant(seed, machines, vehicles, two_lanes=two_lanes).file
    fleet = tuple(_charged(spec, random.uniform(*ranges.battery_frac)) for spec in file.fleet)
    if ranges.scarce_power:
        file = with_scarce_power(file, Random(f"{seed} power"))
    file = msgspec.structs.replace(
        file,
        materials=tuple(_small_material(each, lot_frac) for each in file.materials),
        products=tuple(_small_product(each, lot_frac) for each in file.products),
        machines=tuple(_quick(each, lot_frac, cycle_frac) for each in file.machines),
        fleet=fleet,
    )
    if machines > 1 and Random(f"{seed} has levels").random() < ranges.levels_frac:
        file = with_levels(file, Random(f"{seed} levels"))
    if Random(f"{seed} has stations").random() < ranges.stations_frac:
        file = with_stations(file, Random(f"{seed} stations"))
    if Random(f"{seed} has scrap").random() < ranges.scrap_frac:
        file = with_scrap(file, Random(f"{seed} bad pieces"))
    if Random(f"{seed} has doors").random() < ranges.doors_frac:
        file = with_doors(file, Random(f"{seed} doors"))
    if Random(f"{seed} rests").random() < ranges.rests_frac:
        file = with_rests(file, Random(f"{seed} working time"), Random(f"{seed} people's working time"))
    return Plant(file)


def with_rests(file: PlantFile, random: Random, of_people: Random) -> PlantFile:
    """The same plant with breaks every few minutes; some machines and some areas' people have breaks of their own."""

    def drawn(random: Random) -> WorkingHours:
        minutes, breaks = 0, []
        while (minutes := minutes + random.randint(*WORKS_MIN)) < RESTS_UNTIL_MIN:
            ends = minutes + random.randint(*RESTS_MIN)
            breaks.append(WeeklySpan(_time_of_day(minutes), _time_of_day(ends)))
            minutes = ends
        return WorkingHours(shifts=(WeeklySpan("00:00", "00:00"),), breaks=tuple(breaks))

    machines = tuple(
        msgspec.structs.replace(spec, working_time=drawn(random))
        if random.random() < OWN_RESTS_FRAC
        else spec
        for spec in file.machines
    )
    areas = tuple(
        msgspec.structs.replace(area, working_time=drawn(of_people))
        if of_people.random() < OWN_RESTS_FRAC
        else area
        for area in file.areas
    )
    return msgspec.structs.replace(file, working_time=drawn(random), machines=machines, areas=areas)


def _time_of_day(minutes: int) -> str:
    return f"{minutes // 60:02d}:{minutes % 60:02d}"


def with_scarce_power(file: PlantFile, random: Random) -> PlantFile:
    """The same plant with small batteries, and with few chargers and parking places, at least as many as suffice.

    Chargers suffice when they give the power that the whole fleet needs if it drives all the time. It drives for half
    of its time at most; the rest is for ways to chargers and waits.
    """
    share = random.uniform(*BATTERY_SHARE)
    kinds = {kind.id: kind for kind in file.vehicle_types}
    needs_w = sum(_driving_w(kinds[spec.type]) for spec in file.fleet)
    least = ceil(needs_w / min(kind.charge_w for kind in kinds.values()))
    chargers = random.randint(min(least, len(file.chargers)), len(file.chargers))
    types = tuple(
        msgspec.structs.replace(kind, battery_wh=kind.battery_wh * share) for kind in file.vehicle_types
    )
    file = msgspec.structs.replace(file, vehicle_types=types)
    parkings = random.randint(0, len(file.parkings))
    return msgspec.structs.replace(file, chargers=file.chargers[:chargers], parkings=file.parkings[:parkings])


def _driving_w(kind: VehicleType) -> float:
    """Power of a vehicle that drives all the time, half of it with a load (W)."""
    wh_per_m = (kind.drive_wh_per_m + kind.loaded_wh_per_m) / 2.0
    return kind.idle_w + wh_per_m * kind.max_speed_mps * 3600.0


def _small_material(material: Material, frac: float) -> Material:
    lot = _lot(material.lot, frac)
    return msgspec.structs.replace(material, lot=lot, buffer=3 * lot)


def _small_product(product: Product, frac: float) -> Product:
    return msgspec.structs.replace(product, lot=_lot(product.lot, frac))


def _quick(machine: MachineSpec, lot_frac: float, cycle_frac: float) -> MachineSpec:
    """Short cycles; few goods wait, as few are in a container."""
    makes = tuple(Making(making.product, making.cycle_s * cycle_frac) for making in machine.makes)
    room = max(_lot(machine.goods_capacity, lot_frac), 2 * LEAST_LOT)
    return msgspec.structs.replace(machine, makes=makes, goods_capacity=room)


def _lot(lot: int, frac: float) -> int:
    return max(LEAST_LOT, ceil(lot * frac))


def _charged(spec: VehicleSpec, battery_frac: float) -> VehicleSpec:
    return msgspec.structs.replace(spec, battery_frac=round(battery_frac, 2))
