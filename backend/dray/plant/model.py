"""The plant as it is written down: immutable, in metres, seconds and pieces.

It holds only shapes. `dray.plant.file.file` reads and checks a plant file, `dray.plant.routes` finds ways, and
`dray.plant` ties them together as `Plant`.
"""

from __future__ import annotations

from math import cos, hypot, radians, sin
from typing import Annotated, Literal

import msgspec
from msgspec import Meta

from dray.plant.working_time import WorkingHours

Id = Annotated[str, Meta(pattern=r"^[A-Za-z][A-Za-z0-9_.-]{0,31}$")]
"""Letters, digits, ``_ . -``; begins with a letter, at most 32: it becomes a chunk of a bus key."""

ID_RULE = "write letters, digits, _ . and -, a letter first, at most 32"
"""The same rule, for people whose id is invalid."""


def is_id(text: str) -> bool:
    """Whether a text is a valid name."""
    try:
        msgspec.convert(text, Id)
    except msgspec.ValidationError:
        return False
    return True


Positive = Annotated[float, Meta(gt=0)]
NotNegative = Annotated[float, Meta(ge=0)]
Fraction = Annotated[float, Meta(ge=0, le=1)]
Count = Annotated[int, Meta(ge=1, le=100_000)]
Name = Annotated[
    str,
    Meta(min_length=1, max_length=80, pattern=r"^[^\x00-\x1f\x7f\u202a-\u202e\u2066-\u2069]*(?!\n)$"),
]
"""A name for people: without invisible characters, and without those that change the order of text, as U+202E does."""


class Item(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Base of everything in a plant file: immutable, and a misspelt field is an error."""


class Point(Item, frozen=True):
    """A corner of an area, or of a lane that is not straight."""

    x_m: float
    y_m: float


Foreign = Annotated[str, Meta(min_length=1, max_length=200)]
"""A name that a vehicle, or the system of a layout, uses: any text."""


class MapFrame(Item, frozen=True):
    """Position of a vehicles' map in the plant: it is scaled and mirrored first, then turned, then moved."""

    id: Annotated[str, Meta(max_length=200)] = ""
    """`mapId`; empty for the only one, under any name of the vehicles'."""
    x_m: Annotated[float, Meta(ge=-1e6, le=1e6)] = 0.0
    y_m: Annotated[float, Meta(ge=-1e6, le=1e6)] = 0.0
    """Position of its origin in the plant."""
    heading_deg: Annotated[float, Meta(ge=-360, le=360)] = 0.0
    """Direction of its x axis, from the plant's x axis towards y."""
    mirrored: bool = False
    """Whether its y axis lies to the right of its x axis, and its angles count clockwise."""
    scale: Annotated[float, Meta(ge=1e-4, le=1e4)] = 1.0
    """Metres of the plant per unit of the map. Speeds are in metres a second in any case."""

    def to_plant(self, x: float, y: float, theta: float) -> tuple[float, float, float]:
        """A pose in the map, in the plant's frame: metres and radians, with any turn."""
        turn = radians(self.heading_deg)
        x, y = x * self.scale, y * self.scale
        if self.mirrored:
            y, theta = -y, -theta
        return (
            self.x_m + x * cos(turn) - y * sin(turn),
            self.y_m + x * sin(turn) + y * cos(turn),
            theta + turn,
        )

    def to_map(self, x_m: float, y_m: float) -> tuple[float, float]:
        """A point of the plant, in the map."""
        turn = radians(self.heading_deg)
        dx_m, dy_m = x_m - self.x_m, y_m - self.y_m
        x, y = dx_m * cos(turn) + dy_m * sin(turn), dy_m * cos(turn) - dx_m * sin(turn)
        return x / self.scale, (-y if self.mirrored else y) / self.scale


class VehicleSize(Item, frozen=True):
    """The largest vehicle that may be at a node."""

    length_m: Positive
    width_m: Positive
    """Width with its load."""


class Node(Item, frozen=True):
    """A point of the road network."""

    id: Id
    x_m: float
    y_m: float
    originals: Annotated[tuple[Foreign, ...], Meta(max_length=50)] = ()
    """The vehicles' names for it: the first one is sent to them, all are understood. Left out, its id."""
    map: Annotated[str, Meta(max_length=200)] = ""
    """The one of `maps` that it lies on; left out, the only one."""
    max_vehicle: VehicleSize | None = None
    """Types of vehicles that are longer or wider do not come here. Left out, all may. See `dray.plant.floor.sizes`."""


class LaneType(Item, frozen=True):
    """A type of vehicle that may drive on a lane, and how fast."""

    type: Id
    speed_limit_mps: Positive | None = None
    """Below that of the lane; left out, that of the lane."""


class Lane(Item, frozen=True):
    """A road from one node to another, straight and wide enough for one vehicle unless it says otherwise."""

    start: Id
    end: Id
    speed_limit_mps: Positive = 1.5
    both_ways: bool = False
    """Whether it is two-way."""
    two_lanes: bool | None = None
    """Only with `both_ways`: whether two vehicles can pass one another, each on a lane of its own on the right. If
    left out, the plant's value; a road to a dock is single track. See `dray.plant.layout`."""
    shape: Annotated[tuple[Point, ...], Meta(max_length=200)] = ()
    """The corners between its ends, from `start` on, of a lane that is not straight: a curve is written as short
    pieces. Such a lane is single track, and no vehicle stops on it. See `dray.plant.floor.shapes`."""
    types: Annotated[tuple[LaneType, ...], Meta(max_length=50)] = ()
    """The types of vehicles that may drive on it, where these are not all."""
    original: Foreign | None = None
    """The vehicles' name for it from `start` to `end`. Left out, both nodes with two dashes between them."""
    original_back: Foreign | None = None
    """The vehicles' name for it from `end` to `start`; only with `both_ways`."""


class LaneEnds(Item, frozen=True):
    """One lane of the file, by its nodes, in either direction."""

    start: Id
    end: Id


class Door(Item, frozen=True):
    """A door that opens by itself for vehicles: it stands in the middle of a lane, across it.

    A vehicle waits at the lane's first node until the door stands open. See `dray.plant.floor.doors`.
    """

    id: Id
    name: Name
    lanes: Annotated[tuple[LaneEnds, ...], Meta(min_length=1, max_length=20)]
    """The lanes that lead through it, each once: one that is driven both ways is shut in both directions."""
    opening_s: Positive
    """Time from shut to open, for which a vehicle waits before it (s)."""
    closes_after_s: NotNegative = 5.0
    """Time for which it stays open behind the last vehicle (s)."""


class Box(Item, frozen=True):
    """An area on the floor, for drawing: middle and size."""

    x_m: float
    y_m: float
    width_m: Positive
    depth_m: Positive


class Material(Item, frozen=True):
    """A material that machines consume."""

    id: Id
    name: Name
    lot: Count
    """Pieces in one container: the most that a vehicle brings."""
    buffer: Count
    """Pieces that a machine's buffer holds; at least one lot more than a cycle needs."""
    ability: Id = "tote"
    """Ability that a vehicle needs to carry it."""


class BillLine(Item, frozen=True):
    """One line of a bill of material."""

    material: Id
    """A material, or a part."""
    quantity: Count


class Product(Item, frozen=True):
    """A product of machines: customers order it, or other machines use it, or both."""

    id: Id
    name: Name
    lot: Count
    """Pieces in one container on the way to the delivery warehouse."""
    bill: Annotated[tuple[BillLine, ...], Meta(min_length=1)]
    ability: Id = "tote"
    buffer: Annotated[int, Meta(ge=0, le=100_000)] = 0
    """Pieces in the buffer of each machine that uses it. Such a product is a part: it stands in bills as a material
    does, and storages keep it. 0 for a product that only customers get."""


class Stock(Item, frozen=True):
    """A material or a part in a storage."""

    material: Id
    capacity: Count
    reorder_point: Annotated[int, Meta(ge=0, le=100_000)] | None = None
    """Stock at which more is ordered; only where vehicles refill. Left out, half the capacity, or less where a lot
    would find no room above that."""
    lot: Count | None = None
    """Pieces in one order, at most a container's; only where vehicles refill. Left out, a whole container."""


class Warehouse(Item, frozen=True):
    """A source of material (`source`) or a destination of products (`delivery`)."""

    id: Id
    name: Name
    kind: Literal["source", "delivery"]
    node: Id
    box: Box
    handling_cv: Fraction | None = None
    """Variation of loading and unloading here; that of the vehicle's type if left out."""
    stocks: tuple[Stock, ...] = ()
    """Items of a source warehouse that vehicles fetch there, and their capacity. With any, it has a station, as a
    storage has, and more comes from outside. Without any, nothing is fetched there."""
    original: Foreign | None = None
    """The vehicles' name for it; left out, its id."""
    direct: bool = False
    """Whether machines have these items fetched there themselves, besides from storages; otherwise storages are
    refilled from it, and people may call for them."""

    def as_storage(self) -> Storage:
        """The warehouse as its station sees it: a storage with supplies from outside."""
        return Storage(self.id, self.name, self.node, self.box, self.stocks, self.handling_cv)


class Storage(Item, frozen=True):
    """An interim storage near the machines, refilled from the source warehouse (paper, 4.1)."""

    id: Id
    name: Name
    node: Id
    box: Box
    stocks: Annotated[tuple[Stock, ...], Meta(min_length=1)]
    handling_cv: Fraction | None = None
    """Variation of loading and unloading here; that of the vehicle's type if left out."""
    refill: Literal["itself", "vehicles", "none"] = "itself"
    """Source of its material. `itself`: other means than these vehicles, as in the paper. `vehicles`: its station
    hires them to fetch it from source warehouses. `none`: only transports that people call, as for a manual working
    place. Parts come from their machines."""

    original: Foreign | None = None
    """The vehicles' name for it; left out, its id."""

    def refills(self, item: str) -> bool:
        """Whether vehicles refill it with a material, which is no part."""
        return self.refill == "vehicles" and any(kept.material == item for kept in self.stocks)


class Charger(Item, frozen=True):
    """A charging station: one vehicle at a time."""

    id: Id
    node: Id
    box: Box
    original: Foreign | None = None
    """The vehicles' name for it; left out, its id."""


class Parking(Item, frozen=True):
    """A place where a vehicle waits out of the way."""

    id: Id
    node: Id
    original: Foreign | None = None
    """The vehicles' name for it; left out, its id."""


class Making(Item, frozen=True):
    """A product that a machine can make."""

    product: Id
    cycle_s: Positive
    """Average time (s)."""
    scrap_frac: Fraction = 0.0
    """Fraction of its cycles that end with a bad piece, by chance. Only simulated machines use it; real ones count
    their bad pieces."""
    cycle_cv: Fraction = 0.0
    """Variation of cycles: the standard deviation over the average. Simulated times are log-normal; 0 for always the
    same."""


class MachineSpec(Item, frozen=True):
    """A production machine of a working station."""

    id: Id
    name: Name
    station: Id
    """Its working station."""
    node: Id
    """Node where vehicles dock."""
    box: Box
    makes: Annotated[tuple[Making, ...], Meta(min_length=1)]
    goods_capacity: Count = 30
    """Finished pieces that wait at most; at least the lot of every product it makes."""
    counts: bool = True
    """Whether its dock counts the pieces that vehicles bring and take. Otherwise the vehicles' reports count."""
    working_time: WorkingHours | None = None
    """Its working time; left out, the plant's."""
    handling_cv: Fraction | None = None
    """Variation of loading and unloading here; that of the vehicle's type if left out."""
    original: Foreign | None = None
    """The vehicles' name for it; left out, its id."""


class WorkingStation(Item, frozen=True):
    """A group of machines that belong together."""

    id: Id
    name: Name


class Area(Item, frozen=True):
    """A part of the floor that operators are responsible for."""

    id: Id
    name: Name
    polygon: Annotated[tuple[Point, ...], Meta(min_length=3)]
    working_time: WorkingHours | None = None
    """Working time of its people; left out, the plant's. A person on duty is there at any time."""


class Unassigned(Item, frozen=True):
    """A station of an imported layout without a known purpose. A plant with one is not finished."""

    id: Id
    name: Name
    node: Id
    box: Box | None = None
    part_of: Id | None = None
    """The place at the first node of the same station, where that has several nodes."""
    original: Foreign | None = None
    """The vehicles' name for it; left out, its id."""


Dock = Warehouse | Storage | Charger | Parking | MachineSpec
"""All places with a node where vehicles dock."""


class Hours(Item, frozen=True):
    """A part of every day, in hours of the plant's clock: of UTC in service, from its beginning in a simulation."""

    start_h: Annotated[float, Meta(ge=0, lt=24)]
    end_h: Annotated[float, Meta(gt=0, le=24)]
    """End of the part, which does not belong to it (h). Before `start_h` it is an hour of the next day."""


class Charging(Item, frozen=True):
    """When vehicles of one type charge. Levels are parts of a full battery."""

    must_below_frac: Fraction = 0.25
    """A vehicle with less takes no more work before it has charged for a while (`dray.protocol.vehicle.charging`)."""
    below_frac: Fraction = 0.6
    """Below this level, an idle vehicle goes to charge; above it, it leaves its charger to an emptier one."""
    up_to_frac: Fraction = 0.95
    """Level at which it leaves the charger: the rest would come slowly."""
    opportunity: bool = True
    """Whether it charges when it has no work; else only when it must."""
    quiet_hours: Annotated[tuple[Hours, ...], Meta(max_length=24)] = ()
    """Hours in which it charges only when it must, and only up to `below_frac`."""


class VehicleType(Item, frozen=True):
    """The common properties of all vehicles of one make."""

    id: Id
    name: Name
    length_m: Positive = 0.823
    width_m: Positive = 0.592
    """Width with its load: nothing sticks out of this rectangle. As long and wide as a Neobotix MP-500 (its data
    sheet)."""
    max_speed_mps: Positive = 1.5
    acceleration_mps2: Positive = 0.6
    """Rate of speeding up and braking."""
    turn_speed_mps: Positive = 0.5
    """Highest speed at a node where the way bends by more than 30 degrees."""
    abilities: Annotated[tuple[Id, ...], Meta(min_length=1)] = ("tote",)
    load_s: Positive = 15.0
    """The autonomous loading manoeuvre (paper, [19]), on average."""
    unload_s: Positive = 15.0
    handling_cv: Fraction = 0.0
    """Variation of both (see `Making.cycle_cv`), where a station gives no own one."""
    battery_wh: Positive = 500.0
    drive_wh_per_m: Positive = 0.03
    loaded_wh_per_m: Positive = 0.04
    idle_w: NotNegative = 30.0
    """Power of computers and sensors, moving or not."""
    charge_w: Positive = 600.0
    """Up to `charge_taper_frac`; then falling in a straight line to a tenth of it at full."""
    charge_taper_frac: Fraction = 0.8
    charging: Charging = Charging()

    @property
    def turning_radius_m(self) -> float:
        """Radius of the circle that it sweeps when it turns on the spot: half its diagonal."""
        return hypot(self.length_m, self.width_m) / 2.0

    @property
    def braking_m(self) -> float:
        """Braking distance from its highest speed."""
        return self.max_speed_mps**2 / (2.0 * self.acceleration_mps2)


class VehicleSpec(Item, frozen=True):
    """One vehicle of the fleet."""

    id: Id
    type: Id
    node: Id
    """Its node at the beginning."""
    battery_frac: Fraction = 0.9


class PlantFile(Item, frozen=True):
    """A whole plant file."""

    plant: Id
    name: Name
    width_m: Positive
    height_m: Positive
    nodes: Annotated[tuple[Node, ...], Meta(min_length=1)]
    lanes: Annotated[tuple[Lane, ...], Meta(min_length=1)]
    materials: Annotated[tuple[Material, ...], Meta(min_length=1)]
    products: Annotated[tuple[Product, ...], Meta(min_length=1)]
    warehouses: Annotated[tuple[Warehouse, ...], Meta(min_length=2)]
    storages: tuple[Storage, ...]
    """Empty where machines fetch everything from source warehouses."""
    chargers: Annotated[tuple[Charger, ...], Meta(min_length=1)]
    stations: Annotated[tuple[WorkingStation, ...], Meta(min_length=1)]
    machines: Annotated[tuple[MachineSpec, ...], Meta(min_length=1)]
    vehicle_types: Annotated[tuple[VehicleType, ...], Meta(min_length=1)]
    fleet: Annotated[tuple[VehicleSpec, ...], Meta(min_length=1)]
    parkings: tuple[Parking, ...] = ()
    areas: tuple[Area, ...] = ()
    unassigned: tuple[Unassigned, ...] = ()
    doors: tuple[Door, ...] = ()
    maps: Annotated[tuple[MapFrame, ...], Meta(max_length=200)] = ()
    """The maps of vehicles; none where theirs are the plant's frame."""
    two_lanes: bool = False
    """Whether roads that run both ways have two lanes, where a lane does not say it itself."""
    working_time: WorkingHours | None = None
    """When its machines work, and people are in its areas, where these do not say it themselves; left out, always."""
    time_zone: Annotated[str, Meta(min_length=1, max_length=64)] = "UTC"
    """Time zone of all working times, by its IANA name."""
    cell_m: Positive = 20.0
    """Edge of the grid cells that announcements are addressed to."""
