"""Plants drawn from a seed whose batteries last minutes: few chargers, often at a dead end, and a demand up to the full.

They are those of `dray_sim.plants.draw`, except for the vehicles' consumption and charging. In a plant that passes
`dray plant check` no vehicle runs flat under any demand: vehicles give up work before they run out of power.
"""

from __future__ import annotations

from itertools import pairwise
from math import ceil
from random import Random

import msgspec
from msgspec.structs import replace

from dray.errors import PlantError
from dray.plant import Box, Lane, Node, Plant, PlantFile, VehicleType, parse_plant, plant_yaml
from dray.plant.planning.advice_floor import floor_advice
from dray_sim.plants.draw import draw_plant
from dray_sim.plants.generator import generate_plant
from dray_sim.plants.watch import Watch
from dray_sim.run.stage import Shift, Stage, play, with_right_of_way

HOURS = 0.5
"""A battery of these is spent and filled several times in it."""

LOAD_FRAC = (0.1, 1.0)
"""Range of the machines' time that the demand takes: also more than the vehicles can carry."""

LOT_FRAC, QUICKER = 0.2, (0.1, 0.5)
"""Containers and cycles relative to those of a usual plant with right of way: its vehicles have many transports."""

DEAD_END_M, STEP_M = 9.0, 3.0
"""Length of the road to a charger in a dead end, and distance between its nodes."""


class Charged(msgspec.Struct, frozen=True):
    """The results of one plant's vehicles.

    Attributes:
        refused: the errors that the check found; then nothing was played.
        flat: vehicles that ran flat, each with its time (plant clock), in that order.
        invariants: `held`, or the broken one.
        orders, delivered: numbers of orders.
    """

    seed: int
    refused: str
    flat: tuple[tuple[str, float], ...] = ()
    invariants: str = ""
    orders: int = 0
    delivered: int = 0
    transports: int = 0


def has_right_of_way(seed: int) -> bool:
    """Whether the vehicles of a seed take up room: floors of any shape (`draw_plant`) may be too narrow for that."""
    return seed % 2 == 1


def draw_file(seed: int) -> PlantFile:
    """The plant file of a seed, before the check."""
    random = Random(f"{seed} small batteries")
    file = _floor(seed, random).file
    kept = max(1, min(len(file.chargers), round(len(file.fleet) * random.choice((0.1, 0.25, 0.4, 0.6)))))
    fleet = tuple(replace(spec, battery_frac=round(random.uniform(0.6, 1.0), 2)) for spec in file.fleet)
    file = replace(
        file,
        chargers=file.chargers[:kept],
        parkings=file.parkings[: random.randint(0, len(file.parkings))],
        fleet=fleet,
        vehicle_types=tuple(_with_small_battery(kind, random) for kind in file.vehicle_types),
    )
    longer = _at_a_dead_end(file) if random.random() < 0.5 else file
    return longer if _is_as_wide(longer, file) else file


def _floor(seed: int, random: Random) -> Plant:
    if not has_right_of_way(seed):
        return draw_plant(seed, small=True)
    machines, vehicles = random.randint(1, 6), random.randint(2, 8)
    file = generate_plant(seed, machines, vehicles, two_lanes=random.random() < 0.5).file
    quicker = random.uniform(*QUICKER)
    return Plant(
        replace(
            file,
            materials=tuple(replace(each, lot=ceil(each.lot * LOT_FRAC)) for each in file.materials),
            products=tuple(replace(each, lot=ceil(each.lot * LOT_FRAC)) for each in file.products),
            machines=tuple(
                replace(
                    each,
                    makes=tuple(replace(making, cycle_s=making.cycle_s * quicker) for making in each.makes),
                )
                for each in file.machines
            ),
        )
    )


def _is_as_wide(longer: PlantFile, file: PlantFile) -> bool:
    """Whether a floor with a dead end is one at all, and nothing new on it is too narrow."""
    try:
        plant = parse_plant(plant_yaml(Plant(longer)), "longer")
    except PlantError:
        return False
    return len(list(floor_advice(plant))) <= len(list(floor_advice(Plant(file))))


def _with_small_battery(kind: VehicleType, random: Random) -> VehicleType:
    return replace(
        kind,
        battery_wh=round(random.uniform(8.0, 60.0), 1),
        idle_w=round(random.uniform(5.0, 40.0), 1),
        charge_w=round(random.uniform(80.0, 600.0)),
    )


def _at_a_dead_end(file: PlantFile) -> PlantFile:
    """Move the first charger beyond the upper edge of the floor, to the end of a separate road."""
    docks = {place.node for places in (file.warehouses, file.storages, file.machines) for place in places}
    base = max((node for node in file.nodes if node.id not in docks), key=lambda node: (node.y_m, node.id))
    road = [
        Node(f"deadend{step}", base.x_m, base.y_m + step * STEP_M)
        for step in range(1, round(DEAD_END_M / STEP_M) + 1)
    ]
    end = road[-1]
    box = Box(end.x_m, end.y_m, 1.0, 1.0)
    return replace(
        file,
        height_m=max(file.height_m, end.y_m + STEP_M),
        nodes=(*file.nodes, *road),
        lanes=(
            *file.lanes,
            *(
                Lane(start.id, end.id, 0.8, both_ways=True, two_lanes=False)
                for start, end in pairwise((base, *road))
            ),
        ),
        chargers=(replace(file.chargers[0], node=end.id, box=box), *file.chargers[1:]),
    )


def play_seed(seed: int, *, hours: float = HOURS) -> Charged:
    """Draw a plant, and let it work if the check lets it pass.

    Args:
        seed: decides everything.
        hours: of demand.
    """
    file = draw_file(seed)
    try:
        plant = parse_plant(plant_yaml(Plant(file)), f"plant of seed {seed}")
    except PlantError as error:
        return Charged(seed, str(error))
    watch = Watch(plant)

    async def work(stage: Stage) -> bool:
        stage.listeners.add(watch)
        await stage.until_s(hours * 3600.0)
        return True

    load = Random(f"{seed} load").uniform(*LOAD_FRAC)
    with with_right_of_way(has_right_of_way(seed)):
        played = play(Shift(name="small batteries", duration_s=hours * 3600.0, load=load), plant, seed, work)
    report = played.report
    return Charged(
        seed,
        "",
        tuple(watch.flat.items()),
        played.invariants,
        report.orders_placed,
        report.orders_delivered,
        report.transports,
    )
