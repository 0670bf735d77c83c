"""Small plants by how many there are of each kind: places in a row that is folded like a snake, one after another."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import count, pairwise

from dray.plant import (
    Area,
    BillLine,
    Box,
    Charger,
    Lane,
    MachineSpec,
    Making,
    Material,
    Node,
    Parking,
    PlantFile,
    Point,
    Product,
    Stock,
    Storage,
    VehicleSpec,
    VehicleType,
    Warehouse,
    WorkingStation,
)

PITCH_M = 3.0
PER_ROW = 20
MARGIN_M = 2.0

SOME = {
    "machines": 3,
    "products": 3,
    "materials": 3,
    "storages": 2,
    "chargers": 3,
    "parkings": 3,
    "areas": 2,
    "vehicles": 3,
    "vehicle_types": 2,
    "sources": 1,
    "deliveries": 1,
    "stations": 2,
}
"""A few of every kind."""

MANY = 40

EXTREMES = {
    "one of everything": {},
    **{f"one of {kind}": {**SOME, kind: 1} for kind in SOME},
    **{f"many {kind}": {**SOME, kind: MANY} for kind in SOME},
    **{f"no {kind}": {**SOME, kind: 0} for kind in ("parkings", "areas")},
}
"""Plants in which there is one of a kind, none of a kind that may be absent, or many: the arguments of `plant_file`."""


def plant_file(
    *,
    machines: int = 1,
    products: int = 1,
    materials: int = 1,
    storages: int = 1,
    chargers: int = 1,
    parkings: int = 0,
    areas: int = 0,
    vehicles: int = 1,
    vehicle_types: int = 1,
    sources: int = 1,
    deliveries: int = 1,
    stations: int = 1,
) -> PlantFile:
    """A plant of so many of each; every machine makes what falls to it, and every product is made by somebody.

    Each place has a node of its own on the way past all others, so vehicles meet.
    """
    row = _Row()
    stored = [f"m{number}" for number in range(materials)]
    made = [f"p{number}" for number in range(products)]
    return PlantFile(
        plant="row",
        name="A row",
        warehouses=(
            *(Warehouse(f"IN{n}", f"In {n}", "source", *row.place()) for n in range(sources)),
            *(Warehouse(f"OUT{n}", f"Out {n}", "delivery", *row.place()) for n in range(deliveries)),
        ),
        storages=tuple(
            Storage(
                f"S{n}",
                f"Storage {n}",
                *row.place(),
                tuple(Stock(each, 40) for each in _share(stored, n, storages)),
            )
            for n in range(storages)
        ),
        machines=tuple(
            MachineSpec(
                f"M{n}",
                f"Machine {n}",
                f"W{n % stations}",
                *row.place(),
                tuple(Making(each, 60.0) for each in _share(made, n, machines)),
            )
            for n in range(machines)
        ),
        chargers=tuple(Charger(f"C{n}", *row.place()) for n in range(chargers)),
        parkings=tuple(Parking(f"P{n}", row.place()[0]) for n in range(parkings)),
        fleet=tuple(
            VehicleSpec(f"A{n}", f"cart{n % vehicle_types}", row.place()[0]) for n in range(vehicles)
        ),
        materials=tuple(Material(each, each, lot=4, buffer=12) for each in stored),
        products=tuple(
            Product(each, each, lot=2, bill=(BillLine(stored[n % materials], 3),))
            for n, each in enumerate(made)
        ),
        stations=tuple(WorkingStation(f"W{n}", f"Station {n}") for n in range(stations)),
        vehicle_types=tuple(VehicleType(f"cart{n}", f"Cart {n}") for n in range(vehicle_types)),
        nodes=tuple(row.nodes),
        lanes=tuple(Lane(before.id, after.id, both_ways=True) for before, after in pairwise(row.nodes)),
        areas=tuple(_areas(row, areas)),
        width_m=row.width_m,
        height_m=row.height_m,
    )


class _Row:
    """Where the next place is."""

    def __init__(self) -> None:
        self.nodes: list[Node] = []
        self._numbers = count()

    def place(self) -> tuple[str, Box]:
        number = next(self._numbers)
        row, column = divmod(number, PER_ROW)
        x_m = MARGIN_M + PITCH_M * (column if row % 2 == 0 else PER_ROW - 1 - column)
        y_m = MARGIN_M + PITCH_M * row
        self.nodes.append(Node(f"n{number}", x_m, y_m))
        return f"n{number}", Box(x_m, y_m + 1.0, 1.0, 1.0)

    @property
    def width_m(self) -> float:
        return 2.0 * MARGIN_M + PITCH_M * PER_ROW

    @property
    def height_m(self) -> float:
        return 2.0 * MARGIN_M + PITCH_M * (len(self.nodes) // PER_ROW + 1)


def _share(names: list[str], index: int, takers: int) -> list[str]:
    """What falls to one of several: every name falls to somebody, and nobody goes without."""
    return names[index::takers] or [names[index % len(names)]]


def _areas(row: _Row, number: int) -> Iterator[Area]:
    wide_m = row.width_m / max(number, 1)
    for n in range(number):
        left_m, right_m = n * wide_m, (n + 1) * wide_m
        corners = ((left_m, 0.0), (right_m, 0.0), (right_m, row.height_m), (left_m, row.height_m))
        yield Area(f"AREA{n}", f"Area {n}", tuple(Point(*corner) for corner in corners))
