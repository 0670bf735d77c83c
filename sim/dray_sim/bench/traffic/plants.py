"""Floors to drive on: the default plant with a fleet of any size, and some that are hard in one way each."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from collections.abc import Set as AbstractSet
from math import ceil

import msgspec

from dray.plant import (
    Box,
    Charger,
    Lane,
    MachineSpec,
    Making,
    Node,
    Parking,
    Plant,
    PlantFile,
    Stock,
    Storage,
    VehicleSpec,
    Warehouse,
    WorkingStation,
    default_plant,
    load_plant,
)
from dray_sim.plants.generator import generate_plant

SPUR_MPS = 0.8


def default_with(vehicles: int, *, two_lanes: bool = False) -> Plant:
    """The default plant with another fleet: further vehicles begin on free parking places, then on chargers."""
    file = default_plant().file if two_lanes else load_plant("single-track").file
    taken = {spec.node for spec in file.fleet}
    nodes = [*(place.node for place in file.parkings), *(place.node for place in file.chargers)]
    free = [node for node in nodes if node not in taken]
    more = [
        VehicleSpec(f"ATV{number}", file.fleet[number % len(file.fleet)].type, node)
        for number, node in enumerate(free, len(file.fleet) + 1)
    ]
    return Plant(msgspec.structs.replace(file, fleet=(*file.fleet, *more)[:vehicles]))


def generated(vehicles: int = 50, machines: int = 20, *, two_lanes: bool = False) -> Plant:
    """A plant of the generator, at the density of the default one."""
    return generate_plant(1, machines, vehicles, two_lanes=two_lanes)


def bridge(vehicles: int = 8) -> Plant:
    """Two loops that one single track joins: vehicles in both directions need it."""
    spots: dict[str, tuple[float, float]] = {}
    lanes: list[tuple[str, str]] = []
    docks: list[str] = []
    stands: list[str] = []
    for side, left_m in (("a", 6.0), ("b", 42.0)):
        ring = [
            (0.0, 0.0),
            (6.0, 0.0),
            (12.0, 0.0),
            (12.0, 5.0),
            (12.0, 10.0),
            (6.0, 10.0),
            (0.0, 10.0),
            (0.0, 5.0),
        ]
        for number, (x, y) in enumerate(ring):
            spots[f"{side}{number}"] = (left_m + x, 6.0 + y)
            lanes.append((f"{side}{number}", f"{side}{(number + 1) % len(ring)}"))
        for number, spur in (
            (0, (0.0, -2.5)),
            (2, (0.0, -2.5)),
            (4 if side == "b" else 7, None),
            (6, (0.0, 2.5)),
        ):
            x, y = spots[f"{side}{number}"]
            dx, dy = spur or ((2.5, 0.0) if side == "b" else (-2.5, 0.0))
            spots[f"{side}d{number}"] = (x + dx, y + dy)
            docks.append(f"{side}d{number}")
            lanes.append((f"{side}{number}", f"{side}d{number}"))
        for number, dy in ((1, -2.5), (5, 2.5), (1, 2.5), (5, -2.5)):
            x, y = spots[f"{side}{number}"]
            name = f"{side}p{len(stands)}"
            spots[name] = (x, y + dy)
            stands.append(name)
            lanes.append((f"{side}{number}", name))
    for number, x_m in enumerate((24.0, 30.0, 36.0)):
        spots[f"x{number}"] = (x_m, 11.0)
    lanes += [("a3", "x0"), ("x0", "x1"), ("x1", "x2"), ("x2", "b7")]
    return _plant("bridge", spots, lanes, docks, stands, vehicles, (60.0, 24.0))


def corridor(vehicles: int = 4) -> Plant:
    """One corridor with spurs on both sides, and without an exit at its ends."""
    spots: dict[str, tuple[float, float]] = {}
    lanes: list[tuple[str, str]] = []
    docks: list[str] = []
    stands: list[str] = []
    for number in range(10):
        spots[f"c{number}"] = (4.0 + 4.0 * number, 8.0)
        if number:
            lanes.append((f"c{number - 1}", f"c{number}"))
        name = f"{'p' if number in (1, 4, 6, 8) else 'd'}{number}"
        spots[name] = (4.0 + 4.0 * number, 8.0 + (2.5 if number % 2 else -2.5))
        lanes.append((f"c{number}", name))
        (stands if name.startswith("p") else docks).append(name)
    return _plant("corridor", spots, lanes, docks, stands, vehicles, (44.0, 16.0))


def kiva(vehicles: int = 100) -> Plant:
    """A warehouse of 419 nodes with aisles for one vehicle: 200 shelves, 16 stations at both ends."""
    pitch_m, columns, rows = 1.5, 31, 13
    spots: dict[str, tuple[float, float]] = {}
    lanes: list[tuple[str, str]] = []
    shelves: list[str] = []

    def is_aisle(x: int, y: int) -> bool:
        return y % 3 == 0 or x % 6 == 0

    def name_of(x: int, y: int) -> str:
        return f"{'n' if is_aisle(x, y) else 's'}{x}_{y}"

    for y in range(rows):
        for x in range(columns):
            spots[name_of(x, y)] = (4.0 + pitch_m * x, 3.0 + pitch_m * y)
            if not is_aisle(x, y):
                shelves.append(name_of(x, y))
                lanes.append((name_of(x, y - 1 if y % 3 == 1 else y + 1), name_of(x, y)))
                continue
            lanes += [
                (name_of(x, y), name_of(*ahead))
                for ahead in ((x + 1, y), (x, y + 1))
                if ahead[0] < columns and ahead[1] < rows and is_aisle(*ahead)
            ]
    stations: list[str] = []
    for x, step in ((0, -1), (columns - 1, 1)):
        for y in (1, 2, 4, 5, 7, 8, 10, 11):
            name = f"w{x}_{y}"
            spots[name] = (4.0 + pitch_m * (x + step), 3.0 + pitch_m * y)
            lanes.append((name_of(x, y), name))
            stations.append(name)
    docks = [*stations, *shelves]
    starts = shelves[:: max(len(shelves) // vehicles, 1)][:vehicles]
    return _plant("kiva", spots, lanes, docks, starts, vehicles, (54.0, 24.0), machines=len(stations))


def spurred(
    name: str,
    spots: Mapping[str, tuple[float, float]],
    lanes: Sequence[tuple[str, str]],
    one_way: AbstractSet[tuple[str, str]],
    docks: Sequence[tuple[str, tuple[float, float]]],
    stands: Sequence[tuple[str, tuple[float, float]]],
    size_m: tuple[float, float],
) -> Plant:
    """Roads with docks and parking places on spurs; a vehicle on each parking place.

    Args:
        name: of the plant.
        spots: node -> where it is (x, y).
        lanes: by their ends; two-way, except those in `one_way`.
        one_way: as they may be driven.
        docks: the node from which a spur leads to each, and where it ends (x, y).
        stands: the same of parking places.
        size_m: of the floor.
    """
    ends = {f"d{number}": spur for number, spur in enumerate(docks)}
    ends |= {f"p{number}": spur for number, spur in enumerate(stands)}
    return _plant(
        name,
        {**spots, **{end: spot for end, (_, spot) in ends.items()}},
        [*lanes, *((node, end) for end, (node, _) in ends.items())],
        list(ends)[: len(docks)],
        list(ends)[len(docks) :],
        len(stands),
        size_m,
        one_way=one_way,
    )


def _plant(
    name: str,
    spots: Mapping[str, tuple[float, float]],
    lanes: Iterable[tuple[str, str]],
    docks: Sequence[str],
    stands: Sequence[str],
    vehicles: int,
    size_m: tuple[float, float],
    machines: int = 0,
    one_way: AbstractSet[tuple[str, str]] = frozenset(),
) -> Plant:
    """A plant whose docks are machines, storages and warehouses in turn; vehicles begin where they may stand."""
    base = load_plant("single-track").file
    ends = {*docks, *stands}
    machines = machines or max(ceil(len(docks) / 3), 3)
    source, delivery, *rest = docks[::-1]
    rest.reverse()

    def box(node: str) -> Box:
        return Box(*spots[node], 1.0, 1.0)

    makes = tuple(Making(product.id, 60.0) for product in base.products)
    stocks = tuple(Stock(material.id, material.lot * 10) for material in base.materials)
    parkings = tuple(
        Parking(f"P{number}", node) for number, node in enumerate(stands, 1) if node not in docks
    )
    starts = [spot.node for spot in parkings] or list(stands)
    file = PlantFile(
        plant=name,
        name=name.capitalize(),
        width_m=size_m[0],
        height_m=size_m[1],
        nodes=tuple(Node(node, *spot) for node, spot in spots.items()),
        lanes=tuple(
            Lane(
                start,
                end,
                SPUR_MPS if ends & {start, end} else 1.5,
                both_ways=(start, end) not in one_way,
            )
            for start, end in lanes
        ),
        materials=base.materials,
        products=base.products,
        warehouses=(
            Warehouse("SOURCE", "Source", "source", source, box(source)),
            Warehouse("DELIVERY", "Delivery", "delivery", delivery, box(delivery)),
        ),
        storages=tuple(
            Storage(f"S{number}", f"Storage {number}", node, box(node), stocks)
            for number, node in enumerate(rest[machines:], 1)
        ),
        chargers=(Charger("CH1", starts[-1], box(starts[-1])),),
        parkings=parkings,
        stations=(WorkingStation("WS1", "Working station"),),
        machines=tuple(
            MachineSpec(f"M{number}", f"Machine {number}", "WS1", node, box(node), makes, 80)
            for number, node in enumerate(rest[:machines], 1)
        ),
        vehicle_types=base.vehicle_types,
        fleet=tuple(
            VehicleSpec(f"ATV{number}", base.vehicle_types[number % 2].id, node)
            for number, node in enumerate(starts[:vehicles], 1)
        ),
    )
    return Plant(file)
