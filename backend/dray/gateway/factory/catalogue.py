"""The catalogue: products as people have defined them, over those of the plant file.

A definition is in SQL before it is answered. It needs no announcement to agents: an order brings it to the strategist, by the outbox, which says
it until it is answered, and a goal brings it to the machine. Other gateways find it in SQL within seconds.
"""

from __future__ import annotations

import logging
import re
from collections.abc import Mapping, Sequence

import msgspec
from msgspec.structs import replace

from dray.gateway.http.fault_codes import coded
from dray.gateway.http.problems import FieldError, unusable
from dray.gateway.live.projection import Projection
from dray.gateway.products.drafts import Wanted
from dray.messages import BillLine, Document, MachineCycle, PartDefinition, ProductDefinition
from dray.plant import BillLine as PlantLine
from dray.plant import Plant, Product, product_faults, with_product
from dray.store import Store
from dray.store.orders.products import DefinedProduct
from dray.store.work import Work

MACHINE = re.compile(r"^machines\[(\d+)\](.*)$")

_log = logging.getLogger(__name__)

DEFINITION_BYTES = 24_000
"""Of a definition as JSON: an order of two such products is still a message (`dray.codec.MAX_BYTES`)."""

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

    def parts_of(self, product: str) -> tuple[PartDefinition, ...]:
        """The parts on all levels below a product, as far as people have defined them."""
        plant, found, ahead = self._projection.site.plant, dict[str, None](), [product]
        while ahead:
            known = plant.products.get(ahead.pop())
            for line in () if known is None else known.bill:
                if line.material in plant.parts and line.material not in found:
                    found[line.material] = None
                    ahead.append(line.material)
        return tuple(PartDefinition(part, self._defined[part]) for part in found if part in self._defined)

    def cycles_s(self, product: str) -> Mapping[str, float]:
        """By machine that can make it: seconds for one piece."""
        plant = self._projection.site.plant
        return {machine: plant.cycle_s(machine, product) for machine in plant.machines_for(product)}

    def documents(self, product: str) -> tuple[Document, ...]:
        """Those of a product; one of the plant file has none."""
        known = self._defined.get(product)
        return () if known is None else known.documents

    def own_s(self, machine: str, product: str) -> float | None:
        """What a machine says itself of its time for a product; None where it says nothing."""
        return self._file.cycle_s(machine, product) if machine in self._file.machines_for(product) else None

    def _too_large(self, wanted: Wanted) -> list[FieldError]:
        """Whether a definition is more than orders and goals can carry, by field; nothing for a good one."""
        size = len(msgspec.json.encode(_definition(wanted)))
        if size <= DEFINITION_BYTES:
            return []
        field = "documents" if wanted.documents else "machines"
        return [FieldError.of(field, "definition_too_large", size=size, most=DEFINITION_BYTES)]

    def faults(self, wishes: Sequence[Wanted]) -> list[list[FieldError]]:
        """Why products cannot be made or carried here when they are defined one after the other.

        Returns:
            Of each, what is wrong by field of the body; nothing for a good one.
        """
        plant, found = self._projection.site.plant, []
        for wish in wishes:
            faults = self._faults(plant, wish.product, wish.machines) or self._too_large(wish)
            if not faults:
                plant = with_product(plant, wish.product, wish.machines)
            found.append(faults)
        return found

    def _faults(self, plant: Plant, product: Product, cycles_s: Mapping[str, float]) -> list[FieldError]:
        found = [
            FieldError.of(
                f"machines.{machine}", "machine_unknown", machine=machine, machines=", ".join(plant.machines)
            )
            for machine in cycles_s
            if machine not in plant.machines
        ]
        for machine, cycle_s in cycles_s.items():
            own_s = self.own_s(machine, product.id)
            if own_s is not None and own_s != cycle_s:
                own = FieldError.of(
                    f"machines.{machine}", "machine_own_time", machine=machine, seconds=f"{own_s:g}"
                )
                found.append(own)
        if not cycles_s and not self._file.machines_for(product.id):
            found.append(FieldError.of("machines", "no_machine"))
        return found or [
            FieldError(_of_body(field, plant), *coded(reason))
            for field, reason in product_faults(plant, product, cycles_s)
        ]

    async def define(self, products: Sequence[Wanted], by: str, now_s: float) -> str:
        """Keep products that have no `faults`, all of them or none.

        Args:
            products: as they are from now on.
            by: who does it.
            now_s: wall clock.

        Returns:
            The first of which the revision before is not the newest any more, and nothing was kept; empty when all were.

        Raises:
            Problem: 422, one does not fit any more with what others have defined meanwhile.
            UnavailableError: the database cannot be written.
        """
        rows = [self._row(each, by, now_s) for each in products]
        try:
            async with self._store.write() as work:
                # From here on nobody else defines anything: what was found good may not be so any more.
                await self.look(work)
                if faults := [fault for found in self.faults(products) for fault in found]:
                    raise unusable(*faults)
                for row in rows:
                    await _define(work, row)
        except _ChangedError as changed:
            return changed.product
        for row in rows:
            self._take(row)
        return ""

    def is_news(self, wanted: Wanted) -> bool:
        """Whether a product is to be otherwise than it is, where people have defined it; that is so of all others."""
        known = self._defined.get(wanted.product.id)
        return known is None or replace(_definition(wanted), revision=known.revision) != known

    async def look(self, work: Work) -> None:
        """Learn what was defined since the last look; at the first one, all of it."""
        mark = await work.products.mark()
        if mark == self._mark:
            return
        for row in await work.products.defined():
            if row.id not in self._defined or row.revision > self._defined[row.id].revision:
                self._take(row)
        self._mark = mark

    def _row(self, wanted: Wanted, by: str, now_s: float) -> DefinedProduct:
        product, definition = wanted.product, _definition(wanted)
        written = msgspec.json.encode(definition).decode()
        return DefinedProduct(product.id, product.name, definition.revision, written, by, now_s)

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


class _ChangedError(Exception):
    """Undoes a transaction: somebody has changed a product meanwhile."""

    def __init__(self, product: str) -> None:
        self.product = product
        super().__init__(product)


async def _define(work: Work, row: DefinedProduct) -> None:
    if not await work.products.define(row):
        raise _ChangedError(row.id)


def _definition(wanted: Wanted) -> ProductDefinition:
    product = wanted.product
    return ProductDefinition(
        lot=product.lot,
        ability=product.ability,
        bill=tuple(BillLine(line.material, line.quantity) for line in product.bill),
        name=product.name,
        revision=1 if wanted.before is None else wanted.before + 1,
        machines=tuple(MachineCycle(*each) for each in wanted.machines.items()),
        documents=wanted.documents,
    )


def _of_body(field: str, plant: Plant) -> str:
    """A field of the plant, as the body of a request calls it: its bill and its machines are named there, not numbered."""
    if of_machine := MACHINE.match(field):
        return f"machines.{plant.file.machines[int(of_machine[1])].id}{of_machine[2]}"
    return field.removeprefix("products[0]").removeprefix(".") or "product"
