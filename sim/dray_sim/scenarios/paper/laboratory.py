"""The paper's laboratory (4.3): machine 8, three equal vehicles, and the floor of Figure 1."""

from __future__ import annotations

from msgspec.structs import replace

from dray.plant import MachineSpec, Plant, PlantFile, VehicleSpec, default_plant

MACHINE = "M8"
PRODUCT = "pump-p3"

START_NODES = {"ATV1": "p7", "ATV2": "p6", "ATV3": "p8"}
"""Parking places side by side: ATV3 has the shortest way to the material of machine 8, ATV1 the next one."""

VEHICLE_TYPE = "heavy"
"""Carries everything, so that only the way decides."""


def laboratory() -> Plant:
    """The plant of the experiments."""
    plant = default_plant().file
    fleet = tuple(
        VehicleSpec(id=atv, type=VEHICLE_TYPE, node=node, battery_frac=0.9)
        for atv, node in START_NODES.items()
    )
    return Plant(replace(_only(plant, MACHINE), plant="laboratory", name="Laboratory", fleet=fleet))


def only_on(product: str, machine: str) -> Plant:
    """The default plant, in which no other machine can make this product."""
    plant = default_plant().file
    machines = tuple(
        spec
        if spec.id == machine
        else replace(spec, makes=tuple(m for m in spec.makes if m.product != product))
        for spec in plant.machines
    )
    return Plant(
        replace(plant, plant=f"only-{machine.lower()}", machines=tuple(m for m in machines if m.makes))
    )


def _only(plant: PlantFile, machine: str) -> PlantFile:
    """The same floor with one machine, and with what it needs."""
    specs: tuple[MachineSpec, ...] = tuple(spec for spec in plant.machines if spec.id == machine)
    makes = {making.product for spec in specs for making in spec.makes}
    products = tuple(product for product in plant.products if product.id in makes)
    stations = tuple(station for station in plant.stations if station.id in {spec.station for spec in specs})
    return replace(plant, machines=specs, products=products, stations=stations)
