"""A plant of any size for the map's load test: a grid of streets full of machines and vehicles."""

from __future__ import annotations

import math

import msgspec

from dray.plant.model import Lane, MachineSpec, Node, Parking, PlantFile, Storage, VehicleSpec

STREET_M = 12.0


def crowd(plant: PlantFile, vehicles: int) -> PlantFile:
    """The same materials and products on a floor for this many vehicles."""
    side = max(4, math.ceil(math.sqrt(vehicles / 2)))
    nodes, lanes, machines, storages, parkings = [], [], [], [], []
    for i in range(side):
        for j in range(side):
            x, y = (i + 0.5) * STREET_M, (j + 0.5) * STREET_M
            nodes += [Node(f"n{i}-{j}", x, y), Node(f"d{i}-{j}", x + 3, y), Node(f"p{i}-{j}", x, y + 4)]
            lanes += [
                Lane(f"n{i}-{j}", f"d{i}-{j}", both_ways=True),
                Lane(f"n{i}-{j}", f"p{i}-{j}", both_ways=True),
            ]
            if i:
                lanes.append(Lane(f"d{i - 1}-{j}", f"n{i}-{j}", both_ways=True))
            if j:
                lanes.append(Lane(f"p{i}-{j - 1}", f"n{i}-{j}", both_ways=True))
            parkings.append(Parking(f"P{i}-{j}", f"p{i}-{j}"))
            at = {"x_m": x + 6, "y_m": y + 6, "width_m": 5.0, "depth_m": 3.2}
            box = msgspec.convert(at, type(plant.machines[0].box))
            if (i + j) % 4 == 0:
                storages.append(
                    Storage(f"S{i}-{j}", f"Storage {i}-{j}", f"d{i}-{j}", box, plant.storages[0].stocks)
                )
            else:
                base = plant.machines[(i * side + j) % len(plant.machines)]
                machines.append(
                    MachineSpec(f"M{i}-{j}", base.name, base.station, f"d{i}-{j}", box, base.makes)
                )
    fleet = [
        VehicleSpec(f"ATV{k}", plant.vehicle_types[k % 2].id, f"n{(k * 7) % side}-{(k // side) % side}", 0.9)
        for k in range(vehicles)
    ]
    warehouses = tuple(msgspec.structs.replace(w, node="n0-0") for w in plant.warehouses)
    return msgspec.structs.replace(
        plant, name=f"{vehicles} vehicles", width_m=side * STREET_M, height_m=side * STREET_M, nodes=tuple(nodes),
        lanes=tuple(lanes), machines=tuple(machines), storages=tuple(storages), parkings=tuple(parkings),
        chargers=(), areas=(), warehouses=warehouses, fleet=tuple(fleet),
    )  # fmt: skip
