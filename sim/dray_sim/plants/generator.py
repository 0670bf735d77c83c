"""Plants of any size at the density of the default one, for tests and benchmarks.

A block of the floor holds one machine, two storages, six chargers, six parking places or one warehouse. Their numbers
follow from those of machines and vehicles in the proportions of the default plant. The seed decides their places, and
which machine makes which product. Unlike Figure 1 of the paper, a plant of hundreds of vehicles cannot have its
chargers on the sides.
"""

from __future__ import annotations

from itertools import pairwise
from math import ceil, sqrt
from random import Random
from typing import Literal

import msgspec

from dray.errors import SettingsError
from dray.plant import (
    Area,
    Box,
    Charger,
    MachineSpec,
    Making,
    Parking,
    Plant,
    PlantFile,
    Point,
    Stock,
    Storage,
    VehicleSpec,
    Warehouse,
    WorkingStation,
    default_plant,
)
from dray_sim.plants.blocks import BLOCK_HEIGHT_M, BLOCK_WIDTH_M, MARGIN_M, Blocks

MAX_MACHINES, MAX_VEHICLES = 2_000, 5_000
"""Most machines and vehicles: ten times as many as in measured plants; the floor stays below a kilometre."""

STORAGES_PER_MACHINE = 8 / 12
CHARGERS_PER_VEHICLE = 6 / 8
MACHINES_PER_STATION = 3
MACHINES_PER_WAREHOUSE = 12
"""As in the default plant, which also has a parking place per vehicle."""

ASPECT = 1.5
"""Width of the floor over its height."""

STORAGES_PER_BLOCK = 2
STANDS_PER_BLOCK = 6
"""Chargers or parking places."""

MATERIALS_PER_STORAGE = 3
LOTS_PER_STOCK = 10
AREA_COLUMNS, AREA_ROWS = 3, 2
"""Blocks of one operators' area: about three machines with their storages and other places."""

BORDER_M = 1.0
"""Distance of area borders below and to the left of a lane, so that a machine's dock is in its own area."""

STANDS_M = ((2.0, 2.2), (5.0, 2.2), (8.0, 2.2), (2.0, 5.3), (5.0, 5.3), (8.0, 5.3))
"""Chargers and parking places within their block."""

TWO_LANES_M = {2.0: 2.7, 3.5: 2.7, 5.0: 5.0, 6.5: 7.3, 8.0: 7.3}
"""Positions of spurs on a two-lane road: there is room for a stop point between any two of them, and before a corner."""

LENGTH_M, WIDTH_M = 0.823, 0.592
"""Size of all vehicles, for which blocks leave room."""

MOUTHS_M = 1.5
"""Distance from the middle of a warehouse to its entrance and exit."""


def generate_plant(seed: int, machines: int, vehicles: int, *, two_lanes: bool = True) -> Plant:
    """A plant of the wanted size; the same for the same arguments, in every process.

    Args:
        seed: decides all places, and which machine makes which product.
        machines: how many, from 1 to `MAX_MACHINES`.
        vehicles: how many, from 1 to `MAX_VEHICLES`.
        two_lanes: whether roads have two lanes; the same places are in the same blocks, at spurs with room between
            them. Else they are single track.

    Raises:
        SettingsError: a number is out of its range.
    """
    for name, value, most in (("machines", machines, MAX_MACHINES), ("vehicles", vehicles, MAX_VEHICLES)):
        if not 1 <= value <= most:
            raise SettingsError(name, f"{value} is not within 1 to {most}")
    draft = _Draft(Random(seed), machines, vehicles, two_lanes=two_lanes)
    name = f"g{seed % 10**9}-{machines}-{vehicles}{'' if two_lanes else '-1'}"
    return Plant(draft.file(name, f"Generated from seed {seed}"))


class _Draft:
    """A plant in the making: blocks are dealt out, then places are put into them one by one."""

    def __init__(self, rng: Random, machines: int, vehicles: int, *, two_lanes: bool) -> None:
        self._rng = rng
        self._two_lanes = two_lanes
        self._vehicles = vehicles
        self._stands = {"charger": ceil(vehicles * CHARGERS_PER_VEHICLE), "parking": vehicles}
        self._machines = machines
        # At least two, otherwise a small plant would have all its material on one spot.
        self._storages = max(2, ceil(machines * STORAGES_PER_MACHINE))
        self._warehouses = ceil(machines / MACHINES_PER_WAREHOUSE)
        self._default = default_plant().file
        self._cycle_s = {
            making.product: making.cycle_s for spec in self._default.machines for making in spec.makes
        }
        self._blocks, self._kinds = self._deal()

    def file(self, plant: str, name: str) -> PlantFile:
        """Everything that was drafted."""
        warehouses = (*self._place_warehouses("source"), *self._place_warehouses("delivery"))
        storages = self._place_storages()
        chargers = tuple(
            Charger(f"CH{number}", node, Box(x_m, y_m, 1.9, 1.9))
            for number, (node, x_m, y_m) in enumerate(self._place_stands("charger", "ch"), 1)
        )
        parkings = tuple(
            Parking(f"P{number}", node)
            for number, (node, _, _) in enumerate(self._place_stands("parking", "p"), 1)
        )
        machines = self._place_machines()
        return PlantFile(
            plant=plant,
            name=name,
            width_m=self._blocks.width_m,
            height_m=self._blocks.height_m,
            cell_m=self._default.cell_m,
            nodes=self._blocks.nodes,
            lanes=self._blocks.lanes,
            materials=self._default.materials,
            products=self._default.products,
            warehouses=warehouses,
            storages=storages,
            chargers=chargers,
            parkings=parkings,
            stations=tuple(
                WorkingStation(f"WS{number}", f"Working station {number}")
                for number in range(1, ceil(self._machines / MACHINES_PER_STATION) + 1)
            ),
            machines=machines,
            areas=self._areas(),
            vehicle_types=tuple(
                msgspec.structs.replace(kind, length_m=LENGTH_M, width_m=WIDTH_M)
                for kind in self._default.vehicle_types
            ),
            fleet=self._fleet(parkings),
            two_lanes=self._two_lanes,
        )

    def _deal(self) -> tuple[Blocks, dict[str, list[int]]]:
        """Give every kind of place its blocks: a source lower left, a delivery upper right, as Figure 1."""
        kinds = [
            *["machine"] * self._machines,
            *["storage"] * ceil(self._storages / STORAGES_PER_BLOCK),
            *(kind for kind, count in self._stands.items() for _ in range(ceil(count / STANDS_PER_BLOCK))),
            *["source", "delivery"] * (self._warehouses - 1),
        ]
        count = len(kinds) + 2
        columns = max(2, round(sqrt(count * ASPECT * BLOCK_HEIGHT_M / BLOCK_WIDTH_M)))
        blocks = Blocks(columns, ceil(count / columns))
        kinds += ["empty"] * (blocks.columns * blocks.rows - count)
        self._rng.shuffle(kinds)
        dealt: dict[str, list[int]] = {}
        for block, kind in enumerate(["source", *kinds, "delivery"]):
            dealt.setdefault(kind, []).append(block)
        return blocks, dealt

    def _x_m(self, x_m: float) -> float:
        """Position where a spur leaves its road, from the left of the block."""
        return TWO_LANES_M[x_m] if self._two_lanes else x_m

    def _box(self, block: int, x_m: float, y_m: float, width_m: float, depth_m: float) -> Box:
        left_m, low_m = self._blocks.corner_m(block)
        return Box(left_m + x_m, low_m + y_m, width_m, depth_m)

    def _place_warehouses(self, kind: Literal["source", "delivery"]) -> list[Warehouse]:
        """One warehouse per block; vehicles drive through, so that none waits for another's way out."""
        placed = []
        for number, block in enumerate(self._kinds[kind], 1):
            half_m = self._x_m(5.0 + MOUTHS_M) - 5.0
            node = self._blocks.drive_through(block, f"{kind}{number}", 5.0, 2.0, half_m=half_m)
            box = self._box(block, 5.0, 4.9, 7.0, 3.2)
            name = f"{kind.capitalize()} {number}"
            placed.append(Warehouse(f"{kind.upper()}{number}", name, kind, node, box))
        return placed

    def _place_storages(self) -> tuple[Storage, ...]:
        """Two storages per block; materials rotate, so that each is kept in every part of the floor."""
        materials = self._default.materials
        each = max(MATERIALS_PER_STORAGE, ceil(len(materials) / self._storages))
        placed = []
        for index in range(self._storages):
            block = self._kinds["storage"][index // STORAGES_PER_BLOCK]
            dock_m, box_m = (((3.5, 1.6), (3.5, 2.9)), ((6.5, 5.9), (6.5, 4.6)))[index % STORAGES_PER_BLOCK]
            node = self._blocks.dock(block, f"s{index + 1}", self._x_m(dock_m[0]), dock_m[1])
            kept = [materials[(index * each + step) % len(materials)] for step in range(each)]
            stocks = tuple(Stock(material.id, material.lot * LOTS_PER_STOCK) for material in kept)
            box = self._box(block, self._x_m(box_m[0]), box_m[1], 2.6, 1.8)
            placed.append(Storage(f"S{index + 1}", f"Storage S{index + 1}", node, box, stocks))
        return tuple(placed)

    def _place_stands(self, kind: str, prefix: str) -> list[tuple[str, float, float]]:
        """Six per block, as (node, x_m, y_m)."""
        placed = []
        for index in range(self._stands[kind]):
            block = self._kinds[kind][index // STANDS_PER_BLOCK]
            x_m, y_m = STANDS_M[index % STANDS_PER_BLOCK]
            x_m = self._x_m(x_m)
            left_m, low_m = self._blocks.corner_m(block)
            node = self._blocks.dock(block, f"{prefix}{index + 1}", x_m, y_m)
            placed.append((node, left_m + x_m, low_m + y_m))
        return placed

    def _place_machines(self) -> tuple[MachineSpec, ...]:
        placed = []
        for index, block in enumerate(self._kinds["machine"]):
            node = self._blocks.dock(block, f"m{index + 1}", 5.0, 1.6)
            makes = self._makes(index)
            placed.append(
                MachineSpec(
                    id=f"M{index + 1}",
                    name=f"Machine {index + 1}",
                    station=f"WS{index // MACHINES_PER_STATION + 1}",
                    node=node,
                    box=self._box(block, 5.0, 4.1, 5.2, 3.2),
                    makes=makes,
                    goods_capacity=80,
                )
            )
        return tuple(placed)

    def _makes(self, index: int) -> tuple[Making, ...]:
        """One to three products, more where few machines must make all; they rotate, so that none is missing."""
        products = self._default.products
        least = ceil(len(products) / self._machines)
        count = max(least, self._rng.choice((1, 2, 2, 3)))
        turn = [products[(index * least + step) % len(products)].id for step in range(count)]
        return tuple(Making(product, self._cycle_s[product]) for product in turn)

    def _areas(self) -> tuple[Area, ...]:
        """Rectangles of a few blocks each, which cover the floor."""
        across = _borders(self._blocks.columns, AREA_COLUMNS, BLOCK_WIDTH_M, self._blocks.width_m)
        upward = _borders(self._blocks.rows, AREA_ROWS, BLOCK_HEIGHT_M, self._blocks.height_m)
        corners = [
            (left_m, low_m, right_m, high_m)
            for low_m, high_m in pairwise(upward)
            for left_m, right_m in pairwise(across)
        ]
        return tuple(
            Area(
                f"AREA{number}",
                f"Area {number}",
                (Point(left_m, low_m), Point(right_m, low_m), Point(right_m, high_m), Point(left_m, high_m)),
            )
            for number, (left_m, low_m, right_m, high_m) in enumerate(corners, 1)
        )

    def _fleet(self, parkings: tuple[Parking, ...]) -> tuple[VehicleSpec, ...]:
        """Vehicles on parking places of their own, with their types in turn."""
        types = self._default.vehicle_types
        places = self._rng.sample(parkings, self._vehicles)
        return tuple(
            # A single vehicle must be able to carry everything: the last type can.
            VehicleSpec(
                f"ATV{number}",
                types[-number % len(types)].id,
                place.node,
                round(self._rng.uniform(0.5, 1), 2),
            )
            for number, place in enumerate(places, 1)
        )


def _borders(count: int, step: int, pitch_m: float, extent_m: float) -> list[float]:
    """Borders of areas of `step` blocks along one axis, walls included."""
    inner = (MARGIN_M + index * pitch_m - BORDER_M for index in range(step, count, step))
    return [0.0, *inner, extent_m]
