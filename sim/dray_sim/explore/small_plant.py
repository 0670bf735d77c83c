"""The small plant of one run: generated, with small containers and short cycles, so that much is carried in little time."""

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
from dray_sim.explore.profile import Profile
from dray_sim.people import demand
from dray_sim.plants.generator import generate_plant

TRANSPORT_S = 120.0
"""What a vehicle needs for a transport in a small plant, about: the demand is held below what the fleet carries."""

TWO_LANES_FRAC = 0.5
"""Of the plants, how many have roads of two lanes; on single track vehicles hinder one another most."""

BATTERY_SHARE = (0.04, 0.15)
"""Of the usual battery: it lasts for a quarter of an hour to an hour of driving, and is charged in six to 25 minutes."""

LEAST_LOT = 2
"""Pieces in the smallest container of a run."""


def bearable_load(plant: Plant) -> float:
    """Part of the machines' time at which the whole fleet is busy all the time."""
    busy_frac = 0.0
    for product in plant.products.values():
        loads = 1.0 / product.lot + sum(
            line.quantity / plant.materials[line.material].lot for line in product.bill
        )
        busy_frac += loads * TRANSPORT_S / demand.mean_cycle_s(plant, product.id) / len(plant.products)
    return len(plant.fleet) / (len(plant.machines) * busy_frac)


def small_plant(seed: int, ranges: Profile, random: Random) -> Plant:
    """A generated plant whose containers and buffers are small, so that a lot is carried in a short time."""
    machines, vehicles = random.randint(*ranges.machines), random.randint(*ranges.vehicles)
    lot_frac, cycle_frac = random.uniform(*ranges.lot_frac), random.uniform(*ranges.cycle_frac)
    two_lanes = Random(f"{seed} lanes").random() < TWO_LANES_FRAC
    file = generate_plant(seed, machines, vehicles, two_lanes=two_lanes).file
    fleet = tuple(_charged(spec, random.uniform(*ranges.battery_frac)) for spec in file.fleet)
    if ranges.scarce_power:
        file = with_scarce_power(file, Random(f"{seed} power"))
    return Plant(
        msgspec.structs.replace(
            file,
            materials=tuple(_small_material(each, lot_frac) for each in file.materials),
            products=tuple(_small_product(each, lot_frac) for each in file.products),
            machines=tuple(_quick(each, lot_frac, cycle_frac) for each in file.machines),
            fleet=fleet,
        )
    )


def with_scarce_power(file: PlantFile, random: Random) -> PlantFile:
    """The same plant with small batteries, and with as few chargers and parking places as can do, or more.

    Chargers suffice when they give what the whole fleet would need if it drove all the time: it does so for half of
    its time at most, and the rest is for ways to chargers and waits.
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
    """What a vehicle takes that drives all the time, half of it with a load (W)."""
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
