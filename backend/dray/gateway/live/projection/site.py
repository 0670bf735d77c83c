"""The site: the plant as its file has it, and the machines that have joined since."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence

from msgspec import ValidationError, convert, to_builtins

from dray.errors import PlantError
from dray.messages import JoiningMachine, MachineHeartbeat
from dray.messages.heartbeat import JOINING_MACHINES_MAX
from dray.plant import (
    Defined,
    MachineSpec,
    Plant,
    PlantFile,
    file_with_products,
    file_without_products,
    with_machine,
)


class Site:
    """The places of everything in the plant now.

    Args:
        file: a plant file without faults.

    Attributes:
        plant: replaced as a whole when a machine joins or people define or remove a product; never changes in place.
        products: ids of the products that can be ordered; always the same set.
        former: names by id of products that cannot be ordered any more, for what was ordered before.
        judge: takes each machine that introduces itself, once. By default it joins at once; that lays out the floor
            anew, so a gateway does it outside of its loop (`live.joinings`).
    """

    def __init__(self, file: PlantFile) -> None:
        self.plant = Plant(file)
        self.products = {product.id for product in file.products}
        self.former: Mapping[str, str] = {}
        self.judge: Callable[[MachineSpec], None] = self.join
        self._heard: set[str] = set()
        """Joining machines whose introduction was read, whether they fit the plant or not."""

    def on_heartbeat(self, heartbeat: MachineHeartbeat) -> None:
        """Hand on a joining machine on its first introduction, if a plant file could have it."""
        machine, joining = heartbeat.machine, heartbeat.joining
        if joining is None or machine in self._heard or len(self._heard) >= JOINING_MACHINES_MAX:
            return
        self._heard.add(machine)
        try:
            spec = _spec(machine, joining)
        except ValidationError:
            return
        self.judge(spec)

    def join(self, spec: MachineSpec) -> None:
        """Add a machine; one that does not fit the plant is left out."""
        self.plant = joined(self.plant, spec) or self.plant

    def change_products(self, products: Sequence[Defined], gone: Collection[str] = ()) -> None:
        """Add products that are known to fit this plant, one after the other, without those that are gone."""
        self.plant = self.plant.with_products(
            file_with_products(file_without_products(self.plant.file, gone), products)
        )
        self.products.difference_update(gone)
        self.products.update(product.id for product, _ in products)


def joined(plant: Plant, spec: MachineSpec) -> Plant | None:
    """The plant with one machine more; None if that does not fit. For any thread."""
    try:
        return with_machine(plant, spec, spec.id)
    except PlantError:
        return None


def _spec(machine: str, joining: JoiningMachine) -> MachineSpec:
    """The joining machine as an entry of a plant file.

    Raises:
        ValidationError: no plant file could have this entry.
    """
    told = to_builtins(joining)
    box = {size: told.pop(size) for size in ("x_m", "y_m", "width_m", "depth_m")}
    return convert({"id": machine, "box": box, **told}, MachineSpec)
