"""The plant for agents: every question about the layout is a lookup.

`Plant` trusts its file: `dray.plant.file.file` has checked it, or the code that built it. All orders are those of the
file, so that two processes with one file decide alike.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import cached_property
from math import hypot
from types import MappingProxyType
from typing import Protocol, TypeVar

from msgspec.structs import replace

from dray.plant.charger_queue import ChargerQueue
from dray.plant.floor.doors import doors_on
from dray.plant.floor.geometry import box_of, distance_m, inside
from dray.plant.floor.grid import Grid
from dray.plant.floor.shapes import floor_of
from dray.plant.keeping import Keeping
from dray.plant.layout import Crossing, Layout
from dray.plant.model import (
    Area,
    Charger,
    Door,
    LaneEnds,
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
from dray.plant.spare_places import SparePlaces, spare_nodes
from dray.plant.users import Users
from dray.plant.working_time import WorkingTime


class _HasId(Protocol):
    @property
    def id(self) -> str: ...


_Spec = TypeVar("_Spec", bound=_HasId)


DRAWN_AT_ONCE = 128
"""Most remembered drawn parts of the floor with their nodes: twice as many as one list of closures has."""

RESTRICTED_KEPT = 16
"""Ways under restrictions that are kept. All agents of a process go by the newest list, or by the one before it."""


class Plant:
    """An immutable plant with its indexes.

    Args:
        file: a plant file without faults (`dray.plant.file.check.faults` finds none).
        shared: what a plant has in common whose file differs in its products alone: its floor, with the ways that were found
            on it, and the users of its items.

    Every method that takes an id raises `KeyError` for one that the plant does not have.

    Attributes:
        parts: products of which others are made; each is a material, too.
        materials: items that machines use: external ones, and parts.
        restrictions: of its lanes, as far as they are known; a plant as it stands in its file has none.
        obstructed: lanes with known obstacles; none in a plant as it stands in its file.
    """

    restrictions = OPEN
    obstructed: frozenset[Ends] = frozenset()

    def __init__(self, file: PlantFile, shared: tuple[_Floor, Users] | None = None) -> None:
        self.file = file
        self.id, self.name = file.plant, file.name
        self.width_m, self.height_m, self.cell_m = file.width_m, file.height_m, file.cell_m
        floor, users = shared or (_Floor(file), None)
        self._floor = floor
        layout = floor.layout
        self.door_on = floor.door_on
        """Lane as it is driven, in each direction -> its door."""
        self.driven = _as_driven(file, layout, self.door_on)
        """The file with the nodes and lanes that vehicles drive on; the file itself where no road has two lanes."""
        self.nodes = floor.nodes
        """Nodes of the floor as it is driven: with stop points, without the nodes that these replace."""
        self.crossings: Mapping[str, Crossing] = MappingProxyType(dict(layout.crossings))
        self.stops = floor.stops
        """The nodes where a vehicle may stand: all that lie in no crossing."""
        self.corners: Mapping[Ends, tuple[str, ...]] = MappingProxyType(dict(layout.corners))
        """Lane with a shape, by its ends -> the nodes at its corners, in the order in which they are driven over."""
        self.parts, self.materials = _used(file)
        self.products: Mapping[str, Product] = _by_id(file.products)
        self.warehouses: Mapping[str, Warehouse] = _by_id(file.warehouses)
        self.storages: Mapping[str, Storage] = _by_id(file.storages)
        self._keeping = Keeping(file, self.materials)
        self.stores = self._keeping.stores
        """Places with a station: storages, and the source warehouses where something is fetched, each as a storage."""
        self.chargers: Mapping[str, Charger] = _by_id(file.chargers)
        self.parkings: Mapping[str, Parking] = _by_id(file.parkings)
        self.stations: Mapping[str, WorkingStation] = _by_id(file.stations)
        self.machines: Mapping[str, MachineSpec] = _by_id(file.machines)
        self.areas: Mapping[str, Area] = _by_id(file.areas)
        self._shapes = {area.id: (area.polygon, box_of(area.polygon)) for area in file.areas}
        """The border of every area, and the box around it: most points lie outside of that already."""
        self.vehicle_types = floor.vehicle_types
        self.fleet: Mapping[str, VehicleSpec] = _by_id(file.fleet)
        self.dwell_points: tuple[str, ...] = (*self.chargers, *self.parkings)
        """Places where a vehicle may stay: chargers, then parking places."""
        self.roads = floor.roads
        self._inner, self._crossed = layout.inner, layout.crossed
        self._opposite, self._node_of, self._ways = floor.opposite, floor.node_of, floor.ways
        handled: Iterable[MachineSpec | Storage | Warehouse] = file.machines + file.storages + file.warehouses
        self._handling_cv = {place.id: place.handling_cv for place in handled}
        self._cycle_s = {m.id: {making.product: making.cycle_s for making in m.makes} for m in file.machines}
        self._machines_for = self._makers()
        self._users = Users(self.products, users)
        self._materials_of: dict[str, tuple[str, ...]] = {}
        """By machine, as far as somebody has asked."""
        self._items: dict[str, Material | Product] = {**self.materials, **self.products}
        self.abilities = tuple(sorted({item.ability for item in self._items.values()}))
        """Abilities that the items of this plant need."""
        self._extents: dict[str, Extent] = {}
        self._drawn: dict[tuple[tuple[float, float], ...], Extent] = {}

    def _share(self, plant: Plant) -> None:
        """Be another view of a plant, in place of `__init__`: its file, indexes and ways are this one's, too.

        For a subclass that has restrictions of its own. An attribute that is added to this class is shared by itself.
        """
        vars(self).update(vars(plant))

    def with_products(self, file: PlantFile) -> Plant:
        """The plant of a file that differs from this one's in its products and in what machines make of them alone.

        It costs little: the floor stays, and only products that differ are looked at.

        Raises:
            ValueError: something else differs.
        """
        for field in PlantFile.__struct_fields__:
            before, now = getattr(self.file, field), getattr(file, field)
            if field == "machines":
                before, now = map(_without_products, before), map(_without_products, now)
                if list(before) == list(now):
                    continue
            elif field == "products" or before is now or before == now:
                continue
            raise ValueError(f"the plants differ in their {field}")
        return Plant(file, (self._floor, self._users))

    @property
    def charger_queue(self) -> ChargerQueue:
        """The battery that vehicles need to come to a charger and to wait there, by the plant file alone."""
        ways = self._ways
        if ways.queue is None:
            ways.queue = ChargerQueue(self)
        return ways.queue

    @cached_property
    def spare_places(self) -> SparePlaces:
        """Nodes of the roads where vehicles wait for which there is no dwell point; none where all have one.

        Claimed by their ids, as dwell points are: so no dwell point has the id of one.
        """
        kinds = sorted({spec.type for spec in self.fleet.values()})
        stops = (node for node in self.stops if not self.has_place(node))
        needed = len(self.fleet) - len(self.dwell_points)
        docks = map(self.node_of, self.places)
        goods = map(self.node_of, (*self.machines, *self.storages, *self.warehouses))
        return spare_nodes(self.nodes, map(self.roads_of, kinds), stops, docks, needed, goods)

    def stand_of(self, dwell_point: str) -> str:
        """The node of a dwell point; of a spare place it is its id."""
        return self._node_of.get(dwell_point, dwell_point)

    @cached_property
    def source_warehouses(self) -> tuple[str, ...]:
        """Sources of material."""
        return tuple(each.id for each in self.file.warehouses if each.kind == "source")

    @cached_property
    def delivery_warehouses(self) -> tuple[str, ...]:
        """Destinations of products."""
        return tuple(each.id for each in self.file.warehouses if each.kind == "delivery")

    @property
    def doors(self) -> Mapping[str, Door]:
        """The doors that stand on its lanes, by id."""
        return _by_id(self.file.doors)

    @property
    def ordered(self) -> tuple[str, ...]:
        """Products that go to customers: all that are no parts; of parts alone, these."""
        return tuple(each for each in self.products if each not in self.parts) or tuple(self.parts)

    @property
    def lanes(self) -> tuple[DirectedLane, ...]:
        """All lanes, one per direction, with their lengths."""
        return self.roads.lanes

    def crossing_of(self, node: str) -> str:
        """The crossing that a node lies in; empty for a node where a vehicle may stand."""
        return self._inner.get(node, "")

    def way_back(self, start: str, end: str) -> Ends:
        """The lane in the other direction: the one beside a lane of a two-lane road, otherwise the same lane backwards.

        It may not exist: a one-way road has none.
        """
        return self._opposite.get(end, end), self._opposite.get(start, start)

    def places_on(self, start: str, end: str) -> tuple[str, ...]:
        """Places that a vehicle needs for a lane: the crossing that the lane touches, and the node where it may stop.

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
        """Position of a place's dock, as (x_m, y_m)."""
        node = self.nodes[self._node_of[place]]
        return node.x_m, node.y_m

    @cached_property
    def working_time(self) -> WorkingTime:
        """When its machines work that do not say it themselves."""
        return WorkingTime(self.file.working_time, self.file.time_zone)

    def working_time_of(self, machine: str) -> WorkingTime:
        """When a machine works; for one that the plant does not know, when the plant does."""
        spec = self.machines.get(machine)
        hours = None if spec is None else spec.working_time
        return self.working_time if hours is None else WorkingTime(hours, self.file.time_zone)

    def storages_of(self, material: str) -> tuple[str, ...]:
        """Places where machines fetch a material: storages that keep it, and source warehouses that give it to machines."""
        return self._keeping.for_machines[material]

    def supplies_of(self, material: str) -> tuple[str, ...]:
        """The source warehouses from which storages are refilled with a material."""
        return self._keeping.supplies[material]

    def keepers_of(self, material: str) -> tuple[str, ...]:
        """Places where a material can be fetched and put down: storages, warehouses, and machines with a buffer for it."""
        machines = (machine for machine in self.machines if self.uses(machine, material))
        return (*self._keeping.places[material], *machines)

    def keeps(self, place: str, material: str) -> bool:
        """Whether a place is among the `keepers_of` a material."""
        if place in self.machines and self.uses(place, material):
            return True
        return place in self._keeping.places[material]

    def uses(self, machine: str, item: str) -> bool:
        """Whether any product of a machine needs an item."""
        # The shorter one of both is looked through, up to the first that is in the other.
        return not self._cycle_s[machine].keys().isdisjoint(self._users.of(item))

    def machines_for(self, product: str) -> tuple[str, ...]:
        """The machines that were set up for a product; none for one that is not in the plant file."""
        return self._machines_for.get(product, ())

    def cycle_s(self, machine: str, product: str) -> float:
        """Seconds for one piece of a product on a machine that can make it."""
        return self._cycle_s[machine][product]

    def handling_cv(self, place: str, kind: VehicleType) -> float:
        """Variation of loading and unloading where vehicles of a type dock: standard deviation over average."""
        own = self._handling_cv.get(place)
        return kind.handling_cv if own is None else own

    def materials_of(self, machine: str) -> tuple[str, ...]:
        """Every material that any product of a machine needs."""
        known = self._materials_of.get(machine)
        if known is None:
            known = tuple(material for material in self.materials if self.uses(machine, material))
            self._materials_of[machine] = known
        return known

    def ability_of(self, item: str) -> str:
        """Ability that a vehicle needs for a material or product; empty for an item that is not in the plant file."""
        known = self._items.get(item)
        return "" if known is None else known.ability

    def able(self, ability: str) -> tuple[str, ...]:
        """The vehicles of the fleet with this ability."""
        return tuple(
            vehicle.id
            for vehicle in self.fleet.values()
            if ability in self.vehicle_types[vehicle.type].abilities
        )

    def cell_of(self, x_m: float, y_m: float) -> str:
        """The grid cell of a point, as ``2_1``: column, then row."""
        return self._floor.grid.cell_of(x_m, y_m)

    def cells_within(self, x_m: float, y_m: float, radius_m: float) -> tuple[str, ...]:
        """The grid cells that have a point in common with a circle; never one beyond the floor."""
        return self._floor.grid.within(x_m, y_m, radius_m)

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

        It is a short list for comparing ways: in a large plant most places are out of the question.
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
            extent = self._extents[area] = extent_of(self.areas[area].polygon, self.nodes, self.roads)
        return extent

    def extent_within(self, outline: tuple[tuple[float, float], ...]) -> Extent:
        """The extent of a drawn part of the floor, by its corners (x, y); empty for fewer than three."""
        if len(outline) < 3:
            return Extent(frozenset(), frozenset())
        extent = self._drawn.get(outline)
        if extent is None:
            while len(self._drawn) >= DRAWN_AT_ONCE:
                self._drawn.pop(next(iter(self._drawn)))
            corners = tuple(Point(x_m, y_m) for x_m, y_m in outline)
            extent = self._drawn[outline] = extent_of(corners, self.nodes, self.roads)
        return extent

    def routes(self, vehicle_type: str, restrictions: Restrictions | None = None) -> Routes:
        """The ways of a type of vehicle; the same object for the same type and restrictions.

        Args:
            vehicle_type: its id.
            restrictions: of its lanes; None for the known ones.
        """
        return self._ways.of(vehicle_type, self.restrictions if restrictions is None else restrictions)

    def roads_of(self, vehicle_type: str) -> Roads:
        """The lanes on which a type of vehicle may drive, with the limits that hold for it; of an unknown type, all lanes."""
        return self._ways.roads_of(vehicle_type)

    def _makers(self) -> dict[str, tuple[str, ...]]:
        makers: dict[str, list[str]] = {product: [] for product in self.products}
        for machine, cycles in self._cycle_s.items():
            for product in cycles:
                makers[product].append(machine)
        return {product: tuple(machines) for product, machines in makers.items()}

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Plant) and self.file == other.file

    def __hash__(self) -> int:
        return hash(self.id)

    def __reduce__(self) -> tuple[type[Plant], tuple[PlantFile]]:
        # Another process gets the file and builds its own indexes; caches do not travel.
        return Plant, (self.file,)

    def __repr__(self) -> str:
        return f"<Plant {self.id}: {len(self.machines)} machines, {len(self.fleet)} vehicles>"


class _Floor:
    """The floor of a plant file, and the ways on it: what no product changes."""

    def __init__(self, file: PlantFile) -> None:
        self.layout = layout = floor_of(file)
        self.grid = Grid(file.width_m, file.height_m, file.cell_m)
        self.door_on: Mapping[Ends, Door] = MappingProxyType(doors_on(file, layout))
        self.nodes: Mapping[str, Node] = _by_id(layout.nodes)
        self.stops = tuple(node.id for node in layout.nodes if node.id not in layout.inner)
        self.opposite = opposite_stops(file, self.nodes)
        self.roads = Roads(layout.nodes, layout.lanes, self.door_on)
        self.node_of = {
            dock.id: dock.node
            for docks in (file.machines, file.storages, file.warehouses, file.chargers, file.parkings)
            for dock in docks
        }
        self.vehicle_types: Mapping[str, VehicleType] = _by_id(file.vehicle_types)
        self.ways = _Ways(self.roads, self.vehicle_types, self.node_of)


class _Ways:
    """Ways that were looked for: by type of vehicle, and for the restrictions that were asked for last.

    Attributes:
        queue: at the chargers; computed at the first use, once for all users of the plant.
    """

    def __init__(self, roads: Roads, kinds: Mapping[str, VehicleType], node_of: Mapping[str, str]) -> None:
        self._kinds, self._node_of = kinds, node_of
        self.queue: ChargerQueue | None = None
        self._roads, self._roads_of = roads, {kind: roads.for_type(kind) for kind in kinds}
        self._found: dict[str, Routes] = {}
        self._restricted: dict[tuple[str, Restrictions], Routes] = {}

    def roads_of(self, kind: str) -> Roads:
        return self._roads_of.get(kind, self._roads)

    def of(self, kind: str, restrictions: Restrictions) -> Routes:
        if restrictions == OPEN:
            routes = self._found.get(kind)
            if routes is None:
                routes = self._found[kind] = Routes(self._roads_of[kind], self._kinds[kind], self._node_of)
            return routes
        key = kind, restrictions
        routes = self._restricted.pop(key, None)
        if routes is None:
            routes = Routes(self._roads_of[kind], self._kinds[kind], self._node_of, restrictions)
        self._restricted[key] = routes
        if len(self._restricted) > RESTRICTED_KEPT:
            del self._restricted[next(iter(self._restricted))]
        return routes


def _as_driven(file: PlantFile, layout: Layout, on: Mapping[Ends, Door]) -> PlantFile:
    if layout.lanes is file.lanes:
        return file
    lanes = [(lane.start, lane.end) for lane in layout.lanes]
    doors = tuple(
        replace(door, lanes=tuple(LaneEnds(*ends) for ends in lanes if on.get(ends) == door))
        for door in file.doors
    )
    return replace(file, nodes=layout.nodes, lanes=layout.lanes, two_lanes=False, doors=doors)


def _without_products(machine: MachineSpec) -> MachineSpec:
    return replace(machine, makes=())


def _used(file: PlantFile) -> tuple[Mapping[str, Product], Mapping[str, Material]]:
    """Its parts, and all items that machines use."""
    parts = [product for product in file.products if product.buffer]
    as_materials = [Material(part.id, part.name, part.lot, part.buffer, part.ability) for part in parts]
    return _by_id(parts), _by_id((*file.materials, *as_materials))


def _by_id(specs: Iterable[_Spec]) -> Mapping[str, _Spec]:
    return MappingProxyType({spec.id: spec for spec in specs})
