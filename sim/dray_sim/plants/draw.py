"""Any factory that `dray plant check` accepts, drawn from a seed; it shares nothing with `dray_sim.plants.generator`.

There are 2 to 40 machines and 2 to 60 vehicles of one to four types, in one to three halls with lanes of any shape.
Docks are in the lane, at the end of a spur or drive-through; storages may share a dock; lots have one piece to sixty;
names look like people's.
"""

from __future__ import annotations

from itertools import pairwise
from math import cos, exp, log, pi, sin
from random import Random
from typing import Literal

from msgspec.structs import replace

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
    Plant,
    PlantFile,
    Point,
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
from dray.plant.layout import lay_out
from dray_sim.plants.lanes import Network, draw_lanes, make_one_way

MACHINES = (2, 40)
VEHICLES = (2, 60)
"""Least and most; small numbers are as frequent as large ones."""

SMALL_MACHINES, SMALL_VEHICLES = (2, 6), (2, 8)
"""Sizes of a plant that is played in a second or two."""

STYLES = (
    ("{kind}{number}", "{word} {number}"),
    ("{kind}-{number:03d}", "{word} „{number}“ <b>&amp;</b>"),
    ("x.{kind}_{number}.of-this-plant", '"{word}" #{number}: {{ }} % \\ \''),
    ("{kind}.{number}", "{word} Nº {number} = Größe äöüß 工場"),
    ("Z{number}{kind}", "{word}"),
)
"""Ids and names as different people write them."""

ABILITIES = ("tote", "pallet", "KLT-6428", "long.goods", "A")

SPUR_M = (1.2, 4.0)


def draw_plant(seed: int, *, small: bool = False, two_lanes: bool = False) -> Plant:
    """The plant of a seed; the same in every process.

    Args:
        seed: decides everything.
        small: few machines and vehicles.
        two_lanes: whether its roads have two lanes; the same plant otherwise. Vehicles that would begin in a crossing begin
            at a stop point.

    Raises:
        PlantError: the generator has drawn an invalid plant, which is its own fault.
    """
    random = Random(f"{seed} plant")
    machines = _between(random, SMALL_MACHINES if small else MACHINES)
    vehicles = _between(random, SMALL_VEHICLES if small else VEHICLES)
    file = _Draft(random, seed, machines, vehicles).file()
    if two_lanes:
        file = _begun_at_stops(replace(file, two_lanes=True))
    plant = Plant(file)
    # Through its text and its check, as any other plant comes.
    return parse_plant(plant_yaml(plant), f"plant of seed {seed}")


def _begun_at_stops(file: PlantFile) -> PlantFile:
    """The same plant, with no vehicle in a crossing at the beginning."""
    layout = lay_out(file)
    taken = {spec.node for spec in file.fleet}
    free = [node.id for node in layout.nodes if node.id not in layout.inner and node.id not in taken]
    free.reverse()
    crossed = {node for each in layout.crossings.values() for node in each.nodes}
    fleet = tuple(
        replace(spec, node=free.pop()) if spec.node in crossed and free else spec for spec in file.fleet
    )
    return replace(file, fleet=fleet)


def _between(random: Random, bounds: tuple[int, int]) -> int:
    return round(exp(random.uniform(log(bounds[0]), log(bounds[1]))))


class _Draft:
    """A plant in the making."""

    def __init__(self, random: Random, seed: int, machines: int, vehicles: int) -> None:
        self._random = random
        self._seed = seed
        self._id, self._name = random.choice(STYLES)
        self._chargers = max(1, round(vehicles * random.choice((0.15, 0.4, 0.8, 1.2))))
        self._parkings = round(vehicles * random.choice((0.0, 0.5, 1.0, 1.5)))
        self._storages = max(1, round(machines * random.uniform(0.2, 1.2)))
        self._warehouses = random.choice((1, 1, 2))
        self._machines, self._vehicles = machines, vehicles
        self._docks = machines + self._storages + self._chargers + self._parkings + 2 * self._warehouses
        self._network: Network = draw_lanes(random, max(self._docks, vehicles))
        self._used: set[str] = set()
        self._free = [name for hall in self._network.crossings for name in hall]
        random.shuffle(self._free)

    def file(self) -> PlantFile:
        """Everything, in the order in which it depends on one another."""
        random = self._random
        abilities = random.sample(ABILITIES, random.choice((1, 1, 2, 3)))
        types, fleet_types = self._types(abilities)
        materials = self._materials(abilities)
        products = self._products(abilities, materials)
        sources, deliveries = self._warehouse("source"), self._warehouse("delivery")
        storages = self._place_storages(materials)
        machines = self._place_machines(products)
        chargers = tuple(Charger(self._call("CH", n)[0], *self._place()) for n in range(self._chargers))
        parkings = tuple(Parking(self._call("P", n)[0], self._place()[0]) for n in range(self._parkings))
        make_one_way(self._network, random)
        fleet = self._fleet(fleet_types)
        network = self._network
        return PlantFile(
            plant=f"p{self._seed}",
            name=self._name.format(word="Plant", number=self._seed),
            width_m=round(network.width_m, 2),
            height_m=round(network.height_m, 2),
            cell_m=round(random.uniform(8.0, 50.0), 1),
            nodes=tuple(Node(name, *spot) for name, spot in network.spots.items()),
            lanes=tuple(self._lanes()),
            materials=materials,
            products=products,
            warehouses=(*sources, *deliveries),
            storages=storages,
            chargers=chargers,
            parkings=parkings,
            stations=tuple(
                WorkingStation(*self._call("WS", number)) for number in range(max(1, self._machines // 4))
            ),
            machines=machines,
            areas=self._areas(),
            vehicle_types=types,
            fleet=fleet,
        )

    # --- names ---

    def _call(self, kind: str, number: int) -> tuple[str, str]:
        """Id and name."""
        # Only a few styles end in the number, and truncation must not remove the difference.
        return (
            self._id.format(kind=kind, number=number)[:32],
            self._name.format(word=kind, number=number)[:80],
        )

    # --- what is made of what, and who carries it ---

    def _types(self, abilities: list[str]) -> tuple[tuple[VehicleType, ...], list[str]]:
        """Vehicle types, and the type of every vehicle; some vehicle can carry each item."""
        random = self._random
        count = random.randint(1, min(4, self._vehicles))
        sets = [set(random.sample(abilities, random.randint(1, len(abilities)))) for _ in range(count)]
        for ability in abilities:
            if not any(ability in each for each in sets):
                sets[random.randrange(count)].add(ability)
        types = tuple(self._type(number, tuple(sorted(each))) for number, each in enumerate(sets))
        chosen = [kind.id for kind in types]
        chosen += [random.choice(types).id for _ in range(self._vehicles - count)]
        return types, chosen

    def _type(self, number: int, abilities: tuple[str, ...]) -> VehicleType:
        random = self._random
        metre_wh = random.uniform(0.01, 0.08)
        name, text = self._call("T", number)
        return VehicleType(
            id=name,
            name=text,
            max_speed_mps=round(random.uniform(0.5, 2.5), 2),
            acceleration_mps2=round(random.uniform(0.2, 1.5), 2),
            turn_speed_mps=round(random.uniform(0.2, 1.0), 2),
            abilities=abilities,
            load_s=round(random.uniform(4.0, 60.0), 1),
            unload_s=round(random.uniform(4.0, 60.0), 1),
            battery_wh=round(random.uniform(150.0, 2000.0)),
            drive_wh_per_m=round(metre_wh, 4),
            loaded_wh_per_m=round(metre_wh * random.uniform(1.0, 1.6), 4),
            idle_w=round(random.uniform(0.0, 60.0), 1),
            charge_w=round(random.uniform(200.0, 3000.0)),
            charge_taper_frac=round(random.uniform(0.5, 1.0), 2),
        )

    def _materials(self, abilities: list[str]) -> tuple[Material, ...]:
        random = self._random
        found = []
        for number in range(random.randint(1, 8)):
            lot = _between(random, (1, 60))
            buffer = random.choice((lot + 4, 2 * lot + 4, 3 * lot + 4, 5 * lot + 4))
            name, text = self._call("mat", number)
            found.append(Material(name, text, lot, buffer, random.choice(abilities)))
        return tuple(found)

    def _products(self, abilities: list[str], materials: tuple[Material, ...]) -> tuple[Product, ...]:
        random = self._random
        found = []
        for number in range(random.randint(1, 6)):
            chosen = random.sample(materials, random.randint(1, min(3, len(materials))))
            bill = tuple(BillLine(material.id, random.randint(1, 4)) for material in chosen)
            name, text = self._call("prod", number)
            found.append(Product(name, text, _between(random, (1, 50)), bill, random.choice(abilities)))
        return tuple(found)

    # --- places ---

    def _place(self) -> tuple[str, Box]:
        """A separate dock beside a crossing, or in it, with its box."""
        random, network = self._random, self._network
        base = self._free[len(self._used) % len(self._free)]
        self._used.add(f"{base} {len(self._used)}")
        x_m, y_m = network.spots[base]
        kind = random.choice(("lane", "spur", "spur", "through"))
        if kind != "lane" or base in self._used:
            dock = self._beside(base, f"d{len(network.spots)}")
            speed_mps = random.choice((0.3, 0.8))
            network.join(base, dock, speed_mps)
            neighbours = sorted(end for start, end in network.lanes if start == base and end != dock)
            if kind == "through" and neighbours:
                network.join(dock, random.choice(neighbours), speed_mps)
        else:
            dock = base
        self._used.add(dock)
        x_m, y_m = network.spots[dock]
        return dock, Box(x_m, y_m, 1.0, 1.0)

    def _beside(self, base: str, name: str) -> str:
        """A node near another one, off every other."""
        random, network = self._random, self._network
        x_m, y_m = network.spots[base]
        best, best_gap_m = (x_m, y_m), -1.0
        for _ in range(12):
            angle, far_m = random.uniform(0.0, 2.0 * pi), random.uniform(*SPUR_M)
            spot = x_m + far_m * cos(angle), y_m + far_m * sin(angle)
            gap_m = min((spot[0] - x) ** 2 + (spot[1] - y) ** 2 for x, y in network.spots.values())
            if gap_m > best_gap_m:
                best, best_gap_m = spot, gap_m
        return network.node(name, *best)

    def _warehouse(self, kind: Literal["source", "delivery"]) -> tuple[Warehouse, ...]:
        prefix = "IN" if kind == "source" else "OUT"
        placed = []
        for number in range(self._warehouses):
            node, box = self._place()
            placed.append(Warehouse(*self._call(prefix, number), kind, node, box))
        return tuple(placed)

    def _place_storages(self, materials: tuple[Material, ...]) -> tuple[Storage, ...]:
        random = self._random
        kept: list[list[Material]] = [[] for _ in range(self._storages)]
        for number, material in enumerate(materials):
            kept[number % self._storages].append(material)
        for each in kept:
            others = [material for material in materials if material not in each]
            each.extend(random.sample(others, random.randint(0 if each else 1, min(3, len(others)))))
        placed: list[Storage] = []
        for number, each in enumerate(kept):
            node, box = self._place()
            if placed and random.random() < 0.1:
                # Two racks share one dock.
                node, box = placed[-1].node, placed[-1].box
            stocks = tuple(
                Stock(material.id, max(material.lot, round(material.lot * random.uniform(1.0, 12.0))))
                for material in each
            )
            placed.append(Storage(*self._call("S", number), node, box, stocks))
        return tuple(placed)

    def _place_machines(self, products: tuple[Product, ...]) -> tuple[MachineSpec, ...]:
        random = self._random
        makers: list[list[Product]] = [[] for _ in range(self._machines)]
        for number, product in enumerate(products):
            makers[number % self._machines].append(product)
        for each in makers:
            others = [product for product in products if product not in each]
            each.extend(random.sample(others, random.randint(0 if each else 1, min(2, len(others)))))
        speed_s = exp(random.uniform(log(5.0), log(300.0)))
        placed = []
        for number, each in enumerate(makers):
            node, box = self._place()
            name, text = self._call("M", number)
            makes = tuple(
                Making(product.id, round(speed_s * random.uniform(0.6, 1.6), 1)) for product in each
            )
            room = max(product.lot for product in each)
            station = self._call("WS", random.randrange(max(1, self._machines // 4)))[0]
            placed.append(
                MachineSpec(
                    name,
                    text,
                    station,
                    node,
                    box,
                    makes,
                    goods_capacity=round(room * random.uniform(1.0, 4.0)),
                )
            )
        return tuple(placed)

    def _fleet(self, types: list[str]) -> tuple[VehicleSpec, ...]:
        """Vehicles anywhere on the floor, each on a node of its own."""
        random = self._random
        nodes = sorted(self._network.spots)
        while len(nodes) < len(types):
            nodes.append(self._beside(nodes[0], f"v{len(nodes)}"))
            self._network.join(nodes[0], nodes[-1], 1.0)
        starts = random.sample(nodes, len(types))
        return tuple(
            VehicleSpec(self._call("V", number)[0], kind, node, round(random.uniform(0.4, 1.0), 2))
            for number, (kind, node) in enumerate(zip(types, starts, strict=True))
        )

    def _lanes(self) -> list[Lane]:
        lanes = self._network.lanes
        return [
            Lane(start, end, speed_mps, both_ways=(end, start) in lanes)
            for (start, end), speed_mps in sorted(lanes.items())
            if start < end or (end, start) not in lanes
        ]

    def _areas(self) -> tuple[Area, ...]:
        """No areas, or stripes of the floor."""
        count = self._random.choice((0, 1, 3))
        width_m, height_m = round(self._network.width_m, 2), round(self._network.height_m, 2)
        edges = [min(width_m, width_m * number / count) for number in range(count + 1)] if count else []
        return tuple(
            Area(
                *self._call("AREA", n), (Point(a, 0.0), Point(b, 0.0), Point(b, height_m), Point(a, height_m))
            )
            for n, (a, b) in enumerate(pairwise(edges))
        )
