"""The plant: its places, and the ways between them.

`model` holds the shapes of a plant file, `document` and `file` read it, `check` finds contradictions, and `advice`
predicts shortages by the arithmetic of `flow`. `plant` answers questions, `roads` is the network of lanes, `motion`
the kinematics on it, and `routes` finds ways.
"""

from __future__ import annotations

from dray.plant.file.check import Fault
from dray.plant.file.file import (
    SHIPPED,
    Defined,
    default_plant,
    file_with_products,
    file_without_products,
    is_shipped,
    load_plant,
    parse_plant,
    plant_yaml,
    products_faults,
    shipped_plant,
    sum_up,
    with_machine,
)
from dray.plant.model import (
    Area,
    BillLine,
    Box,
    Charger,
    Charging,
    Door,
    Hours,
    Lane,
    LaneEnds,
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
    Unassigned,
    VehicleSpec,
    VehicleType,
    Warehouse,
    WorkingStation,
)
from dray.plant.plant import Plant
from dray.plant.roads import BEND_RAD, DirectedLane, Roads, bends
from dray.plant.routes import Routes, Way

__all__ = [
    "BEND_RAD",
    "SHIPPED",
    "Area",
    "BillLine",
    "Box",
    "Charger",
    "Charging",
    "Defined",
    "DirectedLane",
    "Door",
    "Fault",
    "Hours",
    "Lane",
    "LaneEnds",
    "MachineSpec",
    "Making",
    "Material",
    "Node",
    "Parking",
    "Plant",
    "PlantFile",
    "Point",
    "Product",
    "Roads",
    "Routes",
    "Stock",
    "Storage",
    "Unassigned",
    "VehicleSpec",
    "VehicleType",
    "Warehouse",
    "Way",
    "WorkingStation",
    "bends",
    "default_plant",
    "file_with_products",
    "file_without_products",
    "is_shipped",
    "load_plant",
    "parse_plant",
    "plant_yaml",
    "products_faults",
    "shipped_plant",
    "sum_up",
    "with_machine",
]
