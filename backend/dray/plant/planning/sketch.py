"""A small plant from a few figures, to begin one's own with: everything along one aisle.

    machines          M1    M2    M3
                      |     |     |
    goods in -- n1 -- n2 -- n3 -- n4 -- n5 -- goods out
                |     |     |     |     |
    storages, chargers and parking places

The plant fulfils the wishes and runs; its author replaces it piece by piece.
"""

from __future__ import annotations

from math import ceil

import msgspec

from dray.plant.model import (
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
from dray.plant.planning.advice import advice
from dray.plant.plant import Plant

PITCH_M = 6.0
"""Distance between places along the aisle: a machine of 4 m and room to walk."""

AISLE_M = 7.0
"""The aisle's distance from the wall below."""

MOST = 40
"""Machines, vehicles or products: a longer aisle is no plant."""

MACHINES_PER_STORAGE = 3

MATERIAL_LOT, PRODUCT_LOT = 20, 10


class Wishes(msgspec.Struct, frozen=True):
    """The figures of a sketch.

    Attributes:
        plant, name: its id and its name; `plant` is an id.
        machines, vehicles, products: from 1 to `MOST`.
        cycle_s: for one piece.
        chargers: 0 for as many as the vehicles need.
    """

    plant: str = "my-plant"
    name: str = "My plant"
    machines: int = 3
    vehicles: int = 2
    products: int = 2
    cycle_s: float = 60.0
    chargers: int = 0


def sketch(wishes: Wishes) -> PlantFile:
    """The plant file; without faults for wishes within their bounds."""
    if wishes.chargers:
        return _file(wishes, wishes.chargers)
    for chargers in range(1, wishes.vehicles + 1):
        file = _file(wishes, chargers)
        if not any(each.kind in ("charger", "queue") for each in advice(Plant(file))):
            return file
    return _file(wishes, wishes.vehicles)


def _file(wishes: Wishes, chargers: int) -> PlantFile:
    storages = ceil(wishes.machines / MACHINES_PER_STORAGE)
    parkings = max(0, wishes.vehicles - chargers)
    below = [
        *(f"s{number}" for number in range(1, storages + 1)),
        *(f"c{number}" for number in range(1, chargers + 1)),
        *(f"p{number}" for number in range(1, parkings + 1)),
    ]
    above = [f"m{number}" for number in range(1, wishes.machines + 1)]
    count = max(len(above), len(below))
    aisle = [Node(f"n{number + 1}", PITCH_M * (number + 1), AISLE_M) for number in range(count)]
    width_m = PITCH_M * (count + 1)
    docks = [
        Node("in", 3.0, AISLE_M),
        Node("out", width_m - 3.0, AISLE_M),
        *(Node(name, aisle[index].x_m, AISLE_M + 2.5) for index, name in enumerate(above)),
        *(Node(name, aisle[index].x_m, AISLE_M - 2.5) for index, name in enumerate(below)),
    ]
    spurs = [
        ("n1", "in"),
        (f"n{count}", "out"),
        *((f"n{index + 1}", name) for names in (above, below) for index, name in enumerate(names)),
    ]
    spots = {node.id: node for node in docks}

    def box(dock: str, up_m: float, width_m: float, depth_m: float) -> Box:
        return Box(spots[dock].x_m, spots[dock].y_m + up_m, width_m, depth_m)

    materials = tuple(f"part-{number}" for number in range(1, wishes.products + 1))
    return PlantFile(
        plant=wishes.plant,
        name=wishes.name,
        width_m=width_m,
        height_m=AISLE_M + 6.0,
        nodes=(*aisle, *docks),
        lanes=(
            *(Lane(f"n{n}", f"n{n + 1}", 1.5, both_ways=True) for n in range(1, count)),
            *(Lane(start, end, 0.8, both_ways=True) for start, end in spurs),
        ),
        materials=(
            *(
                Material(name, name.replace("part-", "Part "), MATERIAL_LOT, 3 * MATERIAL_LOT)
                for name in materials
            ),
            Material("box", "Box", 2 * MATERIAL_LOT, 6 * MATERIAL_LOT),
        ),
        products=tuple(
            Product(
                f"product-{number}",
                f"Product {number}",
                PRODUCT_LOT,
                (BillLine(f"part-{number}", 1), BillLine("box", 1)),
            )
            for number in range(1, wishes.products + 1)
        ),
        warehouses=(
            Warehouse("IN", "Goods in", "source", "in", Box(1.25, AISLE_M, 2.0, 4.0)),
            Warehouse("OUT", "Goods out", "delivery", "out", Box(width_m - 1.25, AISLE_M, 2.0, 4.0)),
        ),
        storages=tuple(
            Storage(
                f"S{n}",
                f"Storage {n}",
                f"s{n}",
                box(f"s{n}", -2.0, 4.0, 2.0),
                (
                    *(Stock(name, 10 * MATERIAL_LOT) for name in materials),
                    Stock("box", 20 * MATERIAL_LOT),
                ),
            )
            for n in range(1, storages + 1)
        ),
        chargers=tuple(
            Charger(f"C{n}", f"c{n}", box(f"c{n}", -1.6, 1.6, 1.6)) for n in range(1, chargers + 1)
        ),
        parkings=tuple(Parking(f"P{n}", f"p{n}") for n in range(1, parkings + 1)),
        stations=(WorkingStation("WS1", "Machines"),),
        machines=tuple(
            MachineSpec(
                f"M{n}",
                f"Machine {n}",
                "WS1",
                f"m{n}",
                box(f"m{n}", 2.0, 4.0, 2.0),
                _makes(wishes, n),
                goods_capacity=4 * PRODUCT_LOT,
            )
            for n in range(1, wishes.machines + 1)
        ),
        areas=(
            Area(
                "FLOOR",
                "Floor",
                (
                    Point(0.0, 0.0),
                    Point(width_m, 0.0),
                    Point(width_m, AISLE_M + 6.0),
                    Point(0.0, AISLE_M + 6.0),
                ),
            ),
        ),
        vehicle_types=(VehicleType("cart", "Cart"),),
        fleet=tuple(
            VehicleSpec(f"V{n}", "cart", [*below[storages:]][n - 1]) for n in range(1, wishes.vehicles + 1)
        ),
    )


def _makes(wishes: Wishes, machine: int) -> tuple[Making, ...]:
    """Products in turn, so that every one has a machine; where there are more machines, most have two."""
    each = max(1, ceil(wishes.products / wishes.machines))
    first = (machine - 1) * each
    count = min(wishes.products, each if wishes.products > wishes.machines else 2)
    return tuple(
        Making(f"product-{(first + step) % wishes.products + 1}", wishes.cycle_s) for step in range(count)
    )
