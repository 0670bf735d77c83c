"""A hall with a raster of roads, drawn from a seed: places at spurs and in the lanes between its crossings, some of them shared.

There are 2 to 40 machines and 2 to 45 vehicles on a floor that is often too small for them. Missing roads make dead
ends and bridges, some roads are one-way, and there may be more vehicles than chargers and parking places. It shares
nothing with `dray_sim.plants.generator` and `dray_sim.plants.draw`. `dray plant check` finds no error in these
plants.
"""

from __future__ import annotations

from itertools import count, pairwise
from math import ceil, exp, hypot, log, sqrt
from random import Random
from typing import Literal

from msgspec.structs import replace

from dray.errors import PlantError
from dray.plant import (
    BillLine,
    Box,
    Charger,
    Lane,
    MachineSpec,
    Making,
    Material,
    Node,
    Parking,
    Plant,
    PlantFile,
    Product,
    Stock,
    Storage,
    VehicleSpec,
    VehicleType,
    Warehouse,
    WorkingStation,
    parse_plant,
    plant_yaml,
)
from dray.plant.planning.room import room_faults
from dray.plant.roads import Roads

MACHINES, VEHICLES = (2, 40), (2, 45)
"""Least and most; small numbers are as frequent as large ones."""

SMALL_MACHINES, SMALL_VEHICLES = (2, 6), (2, 8)
"""Sizes of a plant that is played in a few seconds."""

PITCH_X_M, PITCH_Y_M = (8, 10, 14, 20), (7, 9, 12)
"""Between two crossings."""

SLOT_M = 2.4
"""Between two places on a road, and from a crossing to the first one."""

SPURS_M = (1.3, 1.6, 1.9, 2.6)
"""Distances from a road to a dock."""

BESIDE_M = 1.5
"""Distance from a dock to everything except its entry."""

MARGIN_M = 5.0
"""Distance from the outer roads to the wall."""

MISSING = (0.0, 0.1, 0.25)
"""Part of the roads that may be left out, where everything stays joined."""

ONE_WAY = (0.0, 0.0, 0.3)
"""Part of the roads that may lose a direction, where a way back remains."""

SPEEDS_MPS = (0.8, 1.0, 1.5, 2.0)

ABILITIES = ("tote", "pallet", "long")

ROOM = (1.05, 1.8)
"""Range of the floor's size, as a multiple of the area that its places need."""

IN_LANE = 0.1
"""Part of the places that are in the lane, not at a spur."""

SHARED = 0.15
"""Part of the storages that share the dock of the one before."""

Ends = tuple[str, str]


class _NoRoom(Exception):
    """Chance has left too little room for its places."""


def draw_raster(seed: int, *, small: bool = False) -> Plant:
    """The plant of a seed; the same in every process.

    Args:
        seed: decides everything.
        small: few machines and vehicles.
    """
    for attempt in count():
        random = Random(f"{seed} raster {attempt}")
        try:
            plant = Plant(_Draft(random, f"r{seed}", small=small).file())
            plant = parse_plant(plant_yaml(plant), f"raster of seed {seed}")
        except (PlantError, _NoRoom):
            continue
        if not any(room_faults(plant)):
            return plant
    raise AssertionError  # The loop never ends by itself.


class _Draft:
    """A hall in the making."""

    def __init__(self, random: Random, plant: str, *, small: bool) -> None:
        self._random, self._plant = random, plant
        self._machines = _between(random, SMALL_MACHINES if small else MACHINES)
        self._vehicles = _between(random, SMALL_VEHICLES if small else VEHICLES)
        self._storages = max(1, round(self._machines * random.uniform(0.2, 0.7)))
        self._chargers = max(1, round(self._vehicles * random.choice((0.3, 0.45, 0.6))))
        self._parkings = round(self._vehicles * random.choice((0.0, 0.0, 0.4, 1.0)))
        self._warehouses = 1 + self._machines // 16
        self._spots: dict[str, tuple[float, float]] = {}
        self._roads: dict[Ends, Lane] = {}
        self._spurs: list[Lane] = []
        self._docked: list[tuple[float, float]] = []
        self._draw_roads()
        self._on: dict[Ends, list[tuple[float, str]]] = {ends: [] for ends in self._roads}
        """Places on each road, with how far from its start they are (m)."""
        self._slots = self._draw_slots()

    def file(self) -> PlantFile:
        """Everything.

        Raises:
            _NoRoom: there is too little for its places.
        """
        random = self._random
        abilities = random.sample(ABILITIES, random.randint(1, 3))
        materials, products = self._items(abilities)
        sources = tuple(self._warehouse("SRC", "source", number) for number in range(1, self._warehouses + 1))
        deliveries = tuple(
            self._warehouse("DEL", "delivery", number) for number in range(1, self._warehouses + 1)
        )
        storages = self._place_storages(materials)
        machines = self._place_machines(products)
        chargers = tuple(
            Charger(f"CH{number}", *self._place(f"ch{number}")) for number in range(1, self._chargers + 1)
        )
        parkings = tuple(
            Parking(f"P{number}", self._place(f"p{number}")[0]) for number in range(1, self._parkings + 1)
        )
        types = self._types(abilities)
        fleet = self._fleet(types, [*(one.node for one in chargers), *(one.node for one in parkings)])
        return PlantFile(
            plant=self._plant,
            name=f"Raster {self._plant}",
            width_m=max(x_m for x_m, _ in self._spots.values()) + MARGIN_M,
            height_m=max(y_m for _, y_m in self._spots.values()) + MARGIN_M,
            cell_m=50.0,
            nodes=tuple(Node(name, *spot) for name, spot in self._spots.items()),
            lanes=self._lanes(),
            materials=materials,
            products=products,
            warehouses=(*sources, *deliveries),
            storages=storages,
            chargers=chargers,
            parkings=parkings,
            stations=(WorkingStation("WS1", "Working station 1"),),
            machines=machines,
            areas=(),
            vehicle_types=types,
            fleet=fleet,
        )

    def _warehouse(self, name: str, kind: Literal["source", "delivery"], number: int) -> Warehouse:
        node, box = self._place(f"{name.lower()}{number}")
        return Warehouse(f"{name}{number}", f"{kind.capitalize()} {number}", kind, node, box)

    # --- roads ------------------------------------------------------------------------------------

    def _draw_roads(self) -> None:
        random = self._random
        pitch_x_m, pitch_y_m = random.choice(PITCH_X_M), random.choice(PITCH_Y_M)
        docks = self._machines + self._storages + self._chargers + self._parkings + 2 * self._warehouses
        per_cell = int(pitch_x_m / SLOT_M) + int(pitch_y_m / SLOT_M) - 2
        cells = ceil(docks / per_cell * random.uniform(*ROOM)) + 2
        columns = max(2, round(sqrt(cells * random.uniform(0.7, 2.5))))
        rows = max(2, ceil(cells / columns))
        for x in range(columns):
            for y in range(rows):
                self._spots[f"n{x}-{y}"] = (MARGIN_M + x * pitch_x_m, MARGIN_M + y * pitch_y_m)
        roads = [(f"n{x}-{y}", f"n{x + 1}-{y}") for x in range(columns - 1) for y in range(rows)]
        roads += [(f"n{x}-{y}", f"n{x}-{y + 1}") for x in range(columns) for y in range(rows - 1)]
        for ends in roads:
            self._roads[ends] = Lane(*ends, random.choice(SPEEDS_MPS), both_ways=True)
        for ends in random.sample(roads, round(len(roads) * random.choice(MISSING))):
            self._change(ends, None)
        left = list(self._roads)
        for ends in random.sample(left, round(len(left) * random.choice(ONE_WAY))):
            start, end = ends if random.random() < 0.5 else ends[::-1]
            self._change(ends, replace(self._roads[ends], start=start, end=end, both_ways=False))

    def _change(self, ends: Ends, instead: Lane | None) -> None:
        """Take a road away, or a direction of it, if everything can still be reached from everywhere."""
        changed = {each: lane for each, lane in self._roads.items() if each != ends}
        if instead is not None:
            changed[ends] = instead
        nodes = tuple(Node(name, *spot) for name, spot in self._spots.items())
        roads = Roads(nodes, changed.values())
        if len(roads.reached_from(nodes[0].id)) == len(roads.reaching(nodes[0].id)) == len(nodes):
            self._roads = changed

    # --- places -----------------------------------------------------------------------------------

    def _draw_slots(self) -> list[tuple[Ends, float]]:
        """Possible positions of places on roads: the road, and the distance from its start (m)."""
        slots = []
        for ends, lane in self._roads.items():
            length_m = self._length_m(lane)
            between = int(length_m / SLOT_M) - 1
            slots += [(ends, length_m * number / (between + 1)) for number in range(1, between + 1)]
        self._random.shuffle(slots)
        return slots

    def _length_m(self, lane: Lane) -> float:
        (x_m, y_m), (to_x_m, to_y_m) = self._spots[lane.start], self._spots[lane.end]
        return hypot(to_x_m - x_m, to_y_m - y_m)

    def _place(self, name: str) -> tuple[str, Box]:
        """A separate dock, in the lane or at the end of a spur, with its box.

        Raises:
            _NoRoom: no slot is left.
        """
        random = self._random
        while self._slots:
            ends, along_m = self._slots.pop()
            lane = self._roads[ends]
            length_m = self._length_m(lane)
            (x_m, y_m), (to_x_m, to_y_m) = self._spots[lane.start], self._spots[lane.end]
            ahead_x, ahead_y = (to_x_m - x_m) / length_m, (to_y_m - y_m) / length_m
            entry = (round(x_m + along_m * ahead_x, 2), round(y_m + along_m * ahead_y, 2))
            side = random.choice((-1.0, 1.0))
            if random.random() < IN_LANE:
                self._on[ends].append((along_m, f"l-{name}"))
                self._spots[f"l-{name}"] = entry
                return f"l-{name}", _box(entry, -ahead_y * side, ahead_x * side)
            spur_m = random.choice(SPURS_M)
            for out_x, out_y in ((-ahead_y * side, ahead_x * side), (ahead_y * side, -ahead_x * side)):
                dock = (round(entry[0] + spur_m * out_x, 2), round(entry[1] + spur_m * out_y, 2))
                if min(dock) > 1.0 and all(
                    hypot(dock[0] - x, dock[1] - y) >= BESIDE_M for x, y in self._docked
                ):
                    self._docked.append(dock)
                    self._on[ends].append((along_m, f"l-{name}"))
                    self._spots |= {f"l-{name}": entry, f"d-{name}": dock}
                    self._spurs.append(Lane(f"l-{name}", f"d-{name}", 0.6, both_ways=True))
                    return f"d-{name}", _box(dock, out_x, out_y)
        raise _NoRoom

    def _lanes(self) -> tuple[Lane, ...]:
        """Roads in pieces between crossings and places, and spurs."""
        pieces = []
        for ends, road in self._roads.items():
            names = [road.start, *(name for _, name in sorted(self._on[ends])), road.end]
            pieces += [replace(road, start=start, end=end) for start, end in pairwise(names)]
        return (*pieces, *self._spurs)

    def _place_storages(self, materials: tuple[Material, ...]) -> tuple[Storage, ...]:
        random = self._random
        kept: list[list[Material]] = [[] for _ in range(self._storages)]
        for number, material in enumerate(materials):
            kept[number % self._storages].append(material)
        for each in kept:
            others = [material for material in materials if material not in each]
            each.extend(random.sample(others, random.randint(0 if each else 1, len(others))))
        placed: list[Storage] = []
        for number, each in enumerate(kept, 1):
            if placed and random.random() < SHARED:
                node, box = placed[-1].node, placed[-1].box
            else:
                node, box = self._place(f"s{number}")
            stocks = tuple(Stock(one.id, one.lot * random.choice((1, 2, 4, 10))) for one in each)
            placed.append(Storage(f"S{number}", f"Storage {number}", node, box, stocks))
        return tuple(placed)

    def _place_machines(self, products: tuple[Product, ...]) -> tuple[MachineSpec, ...]:
        random = self._random
        placed = []
        for number in range(self._machines):
            own = products[number % len(products)]
            makes = [own, *(each for each in products if each is not own and random.random() < 0.4)]
            room = max(product.lot for product in makes) * random.choice((2, 3))
            node, box = self._place(f"m{number + 1}")
            placed.append(
                MachineSpec(
                    f"M{number + 1}",
                    f"Machine {number + 1}",
                    "WS1",
                    node,
                    box,
                    tuple(Making(each.id, float(random.choice((20, 45, 90, 180)))) for each in makes),
                    goods_capacity=room,
                )
            )
        return tuple(placed)

    # --- what is made of what, and who carries it ---------------------------------------------------

    def _items(self, abilities: list[str]) -> tuple[tuple[Material, ...], tuple[Product, ...]]:
        random = self._random
        materials = []
        for number in range(1, random.randint(2, 6)):
            lot = random.choice((1, 4, 10, 20))
            buffer = lot * random.choice((2, 4)) + 12
            materials.append(
                Material(f"mat{number}", f"Material {number}", lot, buffer, random.choice(abilities))
            )
        products = []
        # A product that no machine makes is none.
        for number in range(1, min(self._machines, random.randint(2, 6)) + 1):
            used = random.sample(materials, random.randint(1, min(3, len(materials))))
            bill = tuple(BillLine(each.id, random.randint(1, 4)) for each in used)
            lot = random.choice((1, 5, 20))
            products.append(
                Product(f"prod{number}", f"Product {number}", lot, bill, random.choice(abilities))
            )
        return tuple(materials), tuple(products)

    def _types(self, abilities: list[str]) -> tuple[VehicleType, ...]:
        """One type that carries everything, and perhaps a smaller one."""
        random = self._random
        every = VehicleType(
            "all",
            "All",
            max_speed_mps=random.choice((0.8, 1.2, 1.8)),
            abilities=tuple(abilities),
            battery_wh=float(random.choice((400, 600, 1000))),
            load_s=float(random.choice((5, 15, 40))),
            unload_s=float(random.choice((5, 15, 40))),
            charge_w=float(random.choice((600, 1000))),
        )
        small = VehicleType("small", "Small", 0.7, 0.5, abilities=(abilities[0],), charge_w=800.0)
        return (every, small) if random.random() < 0.5 else (every,)

    def _fleet(self, types: tuple[VehicleType, ...], stands: list[str]) -> tuple[VehicleSpec, ...]:
        """Vehicles at chargers and parking places, the rest at crossings; at least two can carry everything.

        Raises:
            _NoRoom: there are more vehicles than places.
        """
        random = self._random
        random.shuffle(stands)
        crossings = [name for name in self._spots if name.startswith("n")]
        random.shuffle(crossings)
        nodes = (stands + crossings)[: self._vehicles]
        if len(nodes) < self._vehicles:
            raise _NoRoom
        return tuple(
            VehicleSpec(
                f"V{number}",
                types[0].id if number < 2 else random.choice(types).id,
                node,
                round(random.uniform(0.5, 1.0), 2),
            )
            for number, node in enumerate(nodes, 1)
        )


def _between(random: Random, bounds: tuple[int, int]) -> int:
    return round(exp(random.uniform(log(bounds[0]), log(bounds[1]))))


def _box(at: tuple[float, float], x: float, y: float) -> Box:
    return Box(round(max(at[0] + x * 1.2, 0.8), 2), round(max(at[1] + y * 1.2, 0.8), 2), 1.5, 1.2)
