"""A yard to try bodies in: a small plant of round numbers, a virtual clock and everything said.

    y 10              north(20,10) --- corner(30,10)
    y  0  west(0,0) -- middle(10,0) -- east(20,0)        and slow, 0.5 m/s: middle -> pit(10,-5)

M1 docks at north, S1 at west, the chargers at east and corner, the warehouses at middle (source) and
corner (delivery). From west to corner the way turns sharply at east (left) and at north (right).
"""

from __future__ import annotations

from collections.abc import Callable
from heapq import heappop

from dray.body import (
    Drive,
    Hold,
    Instruction,
    NodePassed,
    OpenDock,
    Pick,
    Report,
    Unhold,
)
from dray.plant import (
    BillLine,
    Box,
    Charger,
    Lane,
    MachineSpec,
    Making,
    Material,
    Node,
    Plant,
    PlantFile,
    Product,
    Stock,
    VehicleSpec,
    VehicleType,
    Warehouse,
    WorkingStation,
)
from dray.plant.model import Storage as StorageSpec
from dray.ports import Body
from dray_sim.bodies.obstacles import Obstacles
from dray_sim.bodies.stands import Stands
from dray_sim.bodies.stores import DeliveryWarehouse, Place, SourceWarehouse, Storage
from dray_sim.bodies.vehicle.vehicle import SimVehicle
from dray_sim.bodies.workcell import SimWorkcell
from dray_sim.clock.loop import VirtualClock

BOX = Box(5.0, 5.0, 1.0, 1.0)


LIGHT = VehicleType(
    id="light",
    name="Light",
    max_speed_mps=1.0,
    acceleration_mps2=0.5,
    turn_speed_mps=0.5,
    load_s=10.0,
    unload_s=20.0,
    battery_wh=100.0,
    idle_w=36.0,
)
"""One metre per second after one metre; the battery loses a ten-thousandth per second of standing."""


TO_CORNER = ("west", "middle", "east", "north", "corner")

PLANT = Plant(
    PlantFile(
        plant="yard",
        name="Yard",
        width_m=30.0,
        height_m=15.0,
        nodes=(
            Node("west", 0.0, 0.0),
            Node("middle", 10.0, 0.0),
            Node("east", 20.0, 0.0),
            Node("north", 20.0, 10.0),
            Node("corner", 30.0, 10.0),
            Node("pit", 10.0, -5.0),
        ),
        lanes=(
            Lane("west", "middle", both_ways=True),
            Lane("middle", "east", both_ways=True),
            Lane("east", "north", both_ways=True),
            Lane("north", "corner", both_ways=True),
            Lane("middle", "pit", speed_limit_mps=0.5, both_ways=True),
        ),
        materials=(
            Material("shaft", "Shaft", lot=20, buffer=50),
            Material("seal", "Seal", lot=10, buffer=40),
            Material("block", "Block", lot=1, buffer=3, ability="pallet"),
        ),
        products=(
            Product("gear", "Gear", lot=10, bill=(BillLine("shaft", 2), BillLine("seal", 1))),
            Product("pump", "Pump", lot=5, bill=(BillLine("seal", 3),)),
        ),
        warehouses=(
            Warehouse("SOURCE", "Source", "source", "middle", BOX),
            Warehouse("DELIVERY", "Delivery", "delivery", "corner", BOX),
        ),
        storages=(StorageSpec("S1", "Storage", "west", BOX, (Stock("shaft", 60), Stock("seal", 15))),),
        chargers=(Charger("CH1", "east", BOX), Charger("CH2", "corner", BOX)),
        stations=(WorkingStation("WS1", "Turning"),),
        machines=(
            MachineSpec("M1", "Lathe", "WS1", "north", BOX, (Making("gear", 30.0), Making("pump", 60.0)), 12),
        ),
        vehicle_types=(LIGHT,),
        fleet=(VehicleSpec("ATV1", "light", "west"), VehicleSpec("ATV2", "light", "east")),
    )
)


class AttendedStorage(Storage):
    """Its dock is opened for whoever asks: what its station decides is tested elsewhere."""

    def take(self, vehicle: str, item: str, quantity: int) -> str:
        self.instruct(OpenDock(vehicle=vehicle, item=item, quantity=quantity))
        return super().take(vehicle, item, quantity)


class Yard:
    """The yard, its clock, and what its bodies have said: (when, who, what)."""

    def __init__(self, plant: Plant = PLANT) -> None:
        self.plant = plant
        self.clock = VirtualClock()
        self.said: list[tuple[float, str, Report]] = []
        self.source = SourceWarehouse("SOURCE", PLANT.materials)
        self.delivery = DeliveryWarehouse("DELIVERY", PLANT.materials)
        self.storage = AttendedStorage(PLANT.storages["S1"], self.clock, self.source)
        self.workcell = SimWorkcell(PLANT.machines["M1"], PLANT, self.clock)
        places: dict[str, Place] = {
            "SOURCE": self.source,
            "DELIVERY": self.delivery,
            "S1": self.storage,
            "M1": self.workcell,
        }
        self.stands = Stands(PLANT, places)
        self.places, self.chargers = self.stands.places, self.stands.chargers
        self.obstacles = Obstacles(plant)
        self.listen("M1", self.workcell)

    def vehicle(
        self, node: str = "west", battery_frac: float = 0.9, id_: str = "ATV1", type_: VehicleType = LIGHT
    ) -> SimVehicle:
        spec = VehicleSpec(id_, type_.id, node, battery_frac)
        vehicle = SimVehicle(
            spec,
            type_,
            self.plant,
            self.clock,
            self.stands,
            obstacles=self.obstacles,
        )
        self.listen(id_, vehicle)
        return vehicle

    def listen(self, who: str, body: Body) -> None:
        body.attach(lambda report: self.said.append((self.clock.now_s(), who, report)))

    def run(self, until_s: float) -> None:
        """Let everything happen up to `until_s`."""
        while self.clock.heap and self.clock.heap[0][0] <= until_s:
            self.step()
        self.clock.time_s = until_s

    def step(self) -> None:
        """Let the next thing happen."""
        when_s, _, callback, args = heappop(self.clock.heap)
        self.clock.time_s = max(when_s, self.clock.time_s)
        callback(*args)

    def do(self, body: Body, *instructions: Instruction, for_s: float = 0.0) -> list[Report]:
        """Give instructions one after the other, then let time pass; what was said meanwhile."""
        heard = len(self.said)
        for instruction in instructions:
            body.instruct(instruction)
        self.run(self.clock.now_s() + for_s)
        return [report for _, _, report in self.said[heard:]]

    def when(self, wanted: Callable[[Report], bool]) -> list[float]:
        """When it was said."""
        return [at_s for at_s, _, report in self.said if wanted(report)]


def drive(*nodes: str, order: int = 1, released: int | None = None) -> Drive:
    """A way, all of it released unless told otherwise."""
    return Drive(order=order, nodes=nodes, released=len(nodes) if released is None else released)


HOLD, UNHOLD = Hold(), Unhold()


def passed(yard: Yard) -> list[tuple[float, str]]:
    """When which node was passed, in hundredths of a second."""
    return [(round(at_s, 2), said.node) for at_s, _, said in yard.said if isinstance(said, NodePassed)]


def place(vehicle: SimVehicle) -> tuple[float, float]:
    pose = vehicle.sense().pose
    return round(pose.x_m, 6), round(pose.y_m, 6)


PICK = Pick(order=5, station="S1", item="shaft", quantity=20)
