"""The plant as agents ask for it: every question about what stands where, answered by lookup.

`Plant` trusts its file: `dray.plant.file.file` has checked it, or whoever built it in code.
All orders are those of the file, so that two processes with one file decide alike.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from math import hypot
from types import MappingProxyType
from typing import Protocol, TypeVar

from msgspec.structs import replace

from dray.plant.floor.geometry import box_of, distance_m, inside
from dray.plant.floor.grid import Grid
from dray.plant.floor.shapes import floor_of
from dray.plant.layout import Crossing, Layout
from dray.plant.model import (
    Area,
    Charger,
    Dock,
    MachineSpec,
    Material,
    Node,
    Parking,
    PlantFile,
    Point,
    Product,
    Storage,
    VehicleSpec,
    VehicleType,
    Warehouse,
    WorkingStation,
)
from dray.plant.restrictions import OPEN, Ends, Extent, Restrictions, extent_of, opposite_stops
from dray.plant.roads import DirectedLane, Roads
from dray.plant.routes import Routes


class _HasId(Protocol):
    @property
    def id(self) -> str: ...


_Spec = TypeVar("_Spec", bound=_HasId)


RESTRICTED_KEPT = 16
"""Ways under restrictions that are kept. All agents of a process go by the newest list, or by the one before it."""


class Plant:
    """An immutable plant with its indexes.

    Args:
        file: a plant file without faults (`dray.plant.file.check.faults` finds none).

    Every method that takes an id raises `KeyError` for one that the plant does not have.

    Attributes:
        restrictions: of its lanes, as far as whoever asks knows of any; of a plant as it stands in its file there are none.
        obstructed: lanes on which something is known to lie, likewise.
    """

    restrictions = OPEN
    obstructed: frozenset[Ends] = frozenset()

    def __init__(self, file: PlantFile) -> None:
        self.file = file
        self.id, self.name = file.plant, file.name
        self.width_m, self.height_m, self.cell_m = file.width_m, file.height_m, file.cell_m
        layout = floor_of(file)
        self.driven = _as_driven(file, layout)
        """The file with the nodes and lanes that vehicles drive on; the file itself where no road has two lanes."""
        self.nodes: Mapping[str, Node] = _by_id(layout.nodes)
        """Of the floor as it is driven: with stop points, without the nodes of which they are made."""
        self.crossings: Mapping[str, Crossing] = MappingProxyType(dict(layout.crossings))
        self.stops = tuple(node.id for node in layout.nodes if node.id not in layout.inner)
        """The nodes where a vehicle may stand: all that lie in no crossing."""
        self.corners: Mapping[Ends, tuple[str, ...]] = MappingProxyType(dict(layout.corners))
        """Lane with a shape, by its ends -> the nodes at its corners, in the order in which they are driven over."""
        self.materials: Mapping[str, Material] = _by_id(file.materials)
        self.products: Mapping[str, Product] = _by_id(file.products)
        self.warehouses: Mapping[str, Warehouse] = _by_id(file.warehouses)
        self.storages: Mapping[str, Storage] = _by_id(file.storages)
        self.chargers: Mapping[str, Charger] = _by_id(file.chargers)
        self.parkings: Mapping[str, Parking] = _by_id(file.parkings)
        self.stations: Mapping[str, WorkingStation] = _by_id(file.stations)
        self.machines: Mapping[str, MachineSpec] = _by_id(file.machines)
        self.areas: Mapping[str, Area] = _by_id(file.areas)
        self._shapes = {area.id: (area.polygon, box_of(area.polygon)) for area in file.areas}
        """The border of every area, and the box around it: most points lie outside of that already."""
        self.vehicle_types: Mapping[str, VehicleType] = _by_id(file.vehicle_types)
        self.fleet: Mapping[str, VehicleSpec] = _by_id(file.fleet)
        self.dwell_points: tuple[str, ...] = (*self.chargers, *self.parkings)
        """Where a vehicle may stay: chargers, then parking places."""
        self.source_warehouses = tuple(w.id for w in file.warehouses if w.kind == "source")
        self.delivery_warehouses = tuple(w.id for w in file.warehouses if w.kind == "delivery")
        self.roads = Roads(layout.nodes, layout.lanes)
        self._inner, self._crossed = layout.inner, layout.crossed
        self._opposite = opposite_stops(file, self.nodes)
        docks: tuple[Dock, ...] = (
            *file.machines,
            *file.storages,
            *file.warehouses,
            *file.chargers,
            *file.parkings,
        )
        self._node_of = {dock.id: dock.node for dock in docks}
        stations: tuple[MachineSpec | Storage | Warehouse, ...] = (
            *file.machines,
            *file.storages,
            *file.warehouses,
        )
        self._handling_cv = {station.id: station.handling_cv for station in stations}
        self._storages_of = {
            material: tuple(s.id for s in file.storages if any(k.material == material for k in s.stocks))
            for material in self.materials
        }
        self._cycle_s = {m.id: {making.product: making.cycle_s for making in m.makes} for m in file.machines}
        self._machines_for = {
            product: tuple(machine for machine, cycles in self._cycle_s.items() if product in cycles)
            for product in self.products
        }
        self._materials_of = {machine: self._needed(cycles) for machine, cycles in self._cycle_s.items()}
        self._items: dict[str, Material | Product] = {**self.materials, **self.products}
        self.abilities = tuple(sorted({item.ability for item in self._items.values()}))
        """What vehicles must be able to carry in this plant."""
        self._grid = Grid(file.width_m, file.height_m, file.cell_m)
        self._extents: dict[str, Extent] = {}
        self._ways = _Ways(self.roads, self.vehicle_types, self._node_of)

    @property
    def lanes(self) -> tuple[DirectedLane, ...]:
        """All lanes, one per direction, with their lengths."""
        return self.roads.lanes

    def crossing_of(self, node: str) -> str:
        """The crossing that a node lies in; empty for a node where a vehicle may stand."""
        return self._inner.get(node, "")

    def way_back(self, start: str, end: str) -> Ends:
        """The lane that leads back beside a lane of a two-lane road; of any other one, the same lane the other way round.

        It need not be there: a one-way road has none.
        """
        return self._opposite.get(end, end), self._opposite.get(start, start)

    def places_on(self, start: str, end: str) -> tuple[str, ...]:
        """What a vehicle takes up that drives a lane: the crossing that the lane touches, and the node where it may stop.

        A route is driven from stop to stop: all places of its lanes up to the next of `stops` belong together. Both ids
        are of one space: no crossing has the id of a node where a vehicle may stand.
        """
        crossing = self._crossed.get((start, end), "")
        if not crossing:
            return (end,)
        return (crossing,) if end in self._inner else (crossing, end)

    @property
    def diameter_m(self) -> float:
        """The diagonal of the floor: no two points are farther apart."""
        return hypot(self.width_m, self.height_m)

    def node_of(self, place: str) -> str:
        """The node where vehicles dock at a machine, storage, warehouse, charger or parking place."""
        return self._node_of[place]

    def has_place(self, place: str) -> bool:
        """Whether vehicles can dock at something of this id."""
        return place in self._node_of

    @property
    def places(self) -> Iterable[str]:
        """Everything where vehicles dock: machines, storages, warehouses, chargers and parking places."""
        return self._node_of.keys()

    def position_of(self, place: str) -> tuple[float, float]:
        """Where vehicles dock at a place, as (x_m, y_m)."""
        node = self.nodes[self._node_of[place]]
        return node.x_m, node.y_m

    def storages_of(self, material: str) -> tuple[str, ...]:
        """The storages that keep a material."""
        return self._storages_of[material]

    def keepers_of(self, material: str) -> tuple[str, ...]:
        """The places where a material can be fetched and put down: storages, and machines that have a buffer for it."""
        machines = (machine for machine in self.machines if material in self._materials_of[machine])
        return (*self._storages_of[material], *machines)

    def machines_for(self, product: str) -> tuple[str, ...]:
        """The machines that were set up for a product; none for one that is not in the plant file."""
        return self._machines_for.get(product, ())

    def cycle_s(self, machine: str, product: str) -> float:
        """Seconds for one piece of a product on a machine that can make it."""
        return self._cycle_s[machine][product]

    def handling_cv(self, place: str, kind: VehicleType) -> float:
        """How much loading and unloading vary where vehicles of a type dock: standard deviation over average."""
        own = self._handling_cv.get(place)
        return kind.handling_cv if own is None else own

    def materials_of(self, machine: str) -> tuple[str, ...]:
        """Every material that any product of a machine needs."""
        return self._materials_of[machine]

    def ability_of(self, item: str) -> str:
        """What a vehicle must be able to carry for a material or product; empty for one that is not in the plant file."""
        known = self._items.get(item)
        return "" if known is None else known.ability

    def able(self, ability: str) -> tuple[str, ...]:
        """The vehicles of the fleet that can carry what needs this ability."""
        return tuple(
            vehicle.id
            for vehicle in self.fleet.values()
            if ability in self.vehicle_types[vehicle.type].abilities
        )

    def cell_of(self, x_m: float, y_m: float) -> str:
        """The grid cell of a point, as ``2_1``: column, then row."""
        return self._grid.cell_of(x_m, y_m)

    def cells_within(self, x_m: float, y_m: float, radius_m: float) -> tuple[str, ...]:
        """The grid cells that have a point in common with a circle; never one beyond the floor."""
        return self._grid.within(x_m, y_m, radius_m)

    def areas_at(self, x_m: float, y_m: float) -> tuple[str, ...]:
        """The operators' areas that a point lies in; on a common border, all of its areas."""
        point = Point(x_m, y_m)
        return tuple(area.id for area in self.areas.values() if inside(point, area.polygon))

    def is_in(self, x_m: float, y_m: float, areas: Iterable[str]) -> bool:
        """Whether a point lies in one of these areas, borders included."""
        return any(
            left_m <= x_m <= right_m and low_m <= y_m <= high_m and inside(Point(x_m, y_m), polygon)
            for polygon, (left_m, low_m, right_m, high_m) in map(self._shapes.__getitem__, areas)
        )

    def areas_near(self, x_m: float, y_m: float, within_m: float) -> tuple[str, ...]:
        """The operators' areas that a point lies in, or lies at most so far outside of."""
        point = Point(x_m, y_m)
        return tuple(area.id for area in self.areas.values() if distance_m(point, area.polygon) <= within_m)

    def closest(self, node: str, places: Iterable[str], count: int) -> tuple[str, ...]:
        """The `count` places whose docks are closest to a node as the crow flies, closest first.

        A short list for whoever compares ways: in a large plant most places are out of the question.
        """
        here = self.nodes[node]

        def distance_m(place: str) -> float:
            there = self.nodes[self._node_of[place]]
            return hypot(there.x_m - here.x_m, there.y_m - here.y_m)

        return tuple(sorted(places, key=distance_m)[:count])

    def extent_of(self, area: str) -> Extent:
        """The nodes and lanes of an area; worked out when it is asked for first."""
        extent = self._extents.get(area)
        if extent is None:
            extent = self._extents[area] = extent_of(self.areas[area], self.nodes, self.roads)
        return extent

    def routes(self, vehicle_type: str, restrictions: Restrictions | None = None) -> Routes:
        """The ways of a type of vehicle; the same object for the same type and restrictions.

        Args:
            vehicle_type: its id.
            restrictions: of its lanes; None for those that whoever asks knows of.
        """
        return self._ways.of(vehicle_type, self.restrictions if restrictions is None else restrictions)

    def _needed(self, products: Iterable[str]) -> tuple[str, ...]:
        bills = {line.material for product in products for line in self.products[product].bill}
        return tuple(material for material in self.materials if material in bills)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Plant) and self.file == other.file

    def __hash__(self) -> int:
        return hash(self.id)

    def __reduce__(self) -> tuple[type[Plant], tuple[PlantFile]]:
        # Another process gets the file and builds its own indexes; caches do not travel.
        return Plant, (self.file,)

    def __repr__(self) -> str:
        return f"<Plant {self.id}: {len(self.machines)} machines, {len(self.fleet)} vehicles>"


class _Ways:
    """Ways that were looked for: by type of vehicle, and for the restrictions that were asked for last."""

    def __init__(self, roads: Roads, kinds: Mapping[str, VehicleType], node_of: Mapping[str, str]) -> None:
        self._roads, self._kinds, self._node_of = roads, kinds, node_of
        self._found: dict[str, Routes] = {}
        self._restricted: dict[tuple[str, Restrictions], Routes] = {}

    def of(self, kind: str, restrictions: Restrictions) -> Routes:
        if restrictions == OPEN:
            routes = self._found.get(kind)
            if routes is None:
                routes = self._found[kind] = Routes(self._roads, self._kinds[kind], self._node_of)
            return routes
        key = kind, restrictions
        routes = self._restricted.pop(key, None)
        if routes is None:
            routes = Routes(self._roads, self._kinds[kind], self._node_of, restrictions)
        self._restricted[key] = routes
        if len(self._restricted) > RESTRICTED_KEPT:
            del self._restricted[next(iter(self._restricted))]
        return routes


def _as_driven(file: PlantFile, layout: Layout) -> PlantFile:
    if layout.lanes is file.lanes:
        return file
    return replace(file, nodes=layout.nodes, lanes=layout.lanes, two_lanes=False)


def _by_id(specs: Iterable[_Spec]) -> Mapping[str, _Spec]:
    return MappingProxyType({spec.id: spec for spec in specs})
