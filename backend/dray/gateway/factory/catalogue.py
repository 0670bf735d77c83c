"""The catalogue: products as people have defined them, over those of the plant file.

A definition is in SQL before it is answered. It needs no announcement to agents: an order brings it to the strategist, by the outbox, which says
it until it is answered, and a goal brings it to the machine. Other gateways find it in SQL within seconds.
"""

from __future__ import annotations

import logging
import re
from collections.abc import Mapping

import msgspec

from dray.gateway.live.projection import Projection
from dray.messages import BillLine, MachineCycle, ProductDefinition
from dray.plant import BillLine as PlantLine
from dray.plant import Plant, Product
from dray.store import Store
from dray.store.orders.products import DefinedProduct
from dray.store.work import Work

MACHINE = re.compile(r"^machines\[(\d+)\](.*)$")

_log = logging.getLogger(__name__)

PLANT_FILE = 1
"""The revision of what stands in the plant file."""


class Catalogue:
    """What can be ordered, and of what it is made.

    Args:
        store: where definitions are kept.
        projection: its plant follows what is defined.
    """

    def __init__(self, store: Store, projection: Projection) -> None:
        self._store, self._projection = store, projection
        self._file = projection.site.plant
        """As the plant file has it: the machines' own word on their cycles."""
        self._defined: dict[str, ProductDefinition] = {}
        self._mark = 0

    def revision(self, product: str) -> int:
        """Of a product that can be ordered."""
        known = self._defined.get(product)
        return PLANT_FILE if known is None else known.revision

    def definition_of(self, product: str) -> ProductDefinition | None:
        """What an order for a product brings along; None for one that is made as the plant file says."""
        return self._defined.get(product)

    def cycles_s(self, product: str) -> Mapping[str, float]:
        """By machine that can make it: seconds for one piece."""
        plant = self._projection.site.plant
        return {machine: plant.cycle_s(machine, product) for machine in plant.machines_for(product)}

    def own_s(self, machine: str, product: str) -> float | None:
        """What a machine says itself of its time for a product; None where it says nothing."""
        return self._file.cycle_s(machine, product) if machine in self._file.machines_for(product) else None

    def faults(self, product: Product, cycles_s: Mapping[str, float]) -> list[tuple[str, str]]:
        """Why a product cannot be made or carried here, by field of the body; nothing for a good one."""
        plant = self._projection.site.plant
        found = [
            (f"machines.{machine}", f"there is no machine {machine}; there are {', '.join(plant.machines)}")
            for machine in cycles_s
            if machine not in plant.machines
        ]
        for machine, cycle_s in cycles_s.items():
            own_s = self.own_s(machine, product.id)
            if own_s is not None and own_s != cycle_s:
                reason = f"{machine} says itself that a piece takes {own_s:g} s: leave it out, or write that"
                found.append((f"machines.{machine}", reason))
        if not cycles_s and not self._file.machines_for(product.id):
            found.append(("machines", "no machine makes it: name one at least, with its seconds for a piece"))
        return found or [
            (_of_body(field, plant), reason)
            for field, reason in self._projection.site.faults(product, cycles_s)
        ]

    async def define(
        self, product: Product, cycles_s: Mapping[str, float], before: int | None, by: str, now_s: float
    ) -> bool:
        """Keep a product that has no `faults`; whether the revision before it was still the newest.

        Args:
            product: as it is from now on.
            cycles_s: by machine, seconds for one piece.
            before: the revision that is changed; None for a new product.
            by: who does it.
            now_s: wall clock.

        Raises:
            UnavailableError: the database cannot be written.
        """
        definition = ProductDefinition(
            lot=product.lot,
            ability=product.ability,
            bill=tuple(BillLine(line.material, line.quantity) for line in product.bill),
            name=product.name,
            revision=1 if before is None else before + 1,
            machines=tuple(MachineCycle(*each) for each in cycles_s.items()),
        )
        written = msgspec.json.encode(definition).decode()
        row = DefinedProduct(product.id, product.name, definition.revision, written, by, now_s)
        async with self._store.write() as work:
            if not await work.products.define(row):
                return False
        self._take(row)
        return True

    async def look(self, work: Work) -> None:
        """Learn what was defined since the last look; at the first one, all of it."""
        mark = await work.products.mark()
        if mark == self._mark:
            return
        for row in await work.products.defined():
            if row.id not in self._defined or row.revision > self._defined[row.id].revision:
                self._take(row)
        self._mark = mark

    def _take(self, row: DefinedProduct) -> None:
        """Go by a definition; one that fits this plant no longer is left out, and said so."""
        definition = msgspec.json.decode(row.definition, type=ProductDefinition)
        product = Product(
            id=row.id,
            name=row.name,
            lot=definition.lot,
            bill=tuple(PlantLine(line.material, line.quantity) for line in definition.bill),
            ability=definition.ability,
        )
        cycles_s = {each.machine: each.cycle_s for each in definition.machines}
        found = self._projection.site.define(product, cycles_s)
        if found:
            said = "; ".join(f"{field}: {reason}" for field, reason in found)
            _log.error("product %s cannot be made in this plant: %s", row.id, said)
            return
        self._defined[row.id] = definition
        self._projection.materials.note(row.id, [line.material for line in product.bill])


def _of_body(field: str, plant: Plant) -> str:
    """A field of the plant, as the body of a request calls it: its bill and its machines are named there, not numbered."""
    if of_machine := MACHINE.match(field):
        return f"machines.{plant.file.machines[int(of_machine[1])].id}{of_machine[2]}"
    return field.removeprefix("products[0]").removeprefix(".") or "product"
