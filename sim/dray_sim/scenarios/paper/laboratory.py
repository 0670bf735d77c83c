"""The paper's laboratory (4.3), and plants in which one machine alone can make a product."""

from __future__ import annotations

from msgspec.structs import replace

from dray.plant import Plant, default_plant, load_plant

MACHINE = "M8"
PRODUCT = "pump-p3"


def laboratory() -> Plant:
    """The plant of the experiments, as it ships."""
    return load_plant("laboratory")


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
