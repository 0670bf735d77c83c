"""The catalogue: products as people have defined them, over those of the plant file.

A definition is in SQL before it is answered. It needs no announcement to agents: an order brings it to the strategist, by the outbox, which says
it until it is answered, and a goal brings it to the machine. Other gateways find it in SQL within seconds.
"""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Mapping, Sequence

import msgspec
from msgspec.structs import replace

from dray.gateway.http.problems import FieldError, unusable
from dray.gateway.live.projection import Projection
from dray.gateway.products.drafts import Wanted
from dray.gateway.products.judging import Known, definition, faults, own_s
from dray.messages import Document, PartDefinition, ProductDefinition
from dray.plant import BillLine as PlantLine
from dray.plant import Plant, Product
from dray.store import Store
from dray.store.orders.products import DefinedProduct
from dray.store.work import Work

_log = logging.getLogger(__name__)

PLANT_FILE = 1
"""The revision of what stands in the plant file."""

BATCH = 50
"""Products that are taken in at once: some milliseconds of the event loop, however many there are already."""


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
        return own_s(self._file, machine, product)

    def known(self) -> Known:
        """What products are judged by at this moment."""
        plant = self._projection.site.plant
        revisions = {product: self.revision(product) for product in self._projection.site.products}
        return Known(msgspec.json.encode(plant.file), msgspec.json.encode(self._file.file), revisions)

    def faults(self, wishes: Sequence[Wanted]) -> list[list[FieldError]]:
        """Why products cannot be made or carried here when they are defined one after the other; see `judging.faults`."""
        return faults(self._file, self._projection.site.plant.file, wishes)

    async def define(self, products: Sequence[Wanted], by: str, now_s: float, judged: Plant) -> str:
        """Keep products that have no `faults`, all of them or none.

        Args:
            products: as they are from now on.
            judged: the plant in which they have none.
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
                if self._projection.site.plant is not judged:
                    self._judge_again(products)
                for row in rows:
                    await _define(work, row)
        except _ChangedError as changed:
            return changed.product
        if self._projection.site.plant is judged:
            await self._take_all(products, rows)
        else:
            for row in rows:
                self._take(row)
                await asyncio.sleep(0)
        return ""

    def is_news(self, wanted: Wanted) -> bool:
        """Whether a product is to be otherwise than it is, where people have defined it; that is so of all others."""
        known = self._defined.get(wanted.product.id)
        return known is None or replace(definition(wanted), revision=known.revision) != known

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
        product, defined = wanted.product, definition(wanted)
        written = msgspec.json.encode(defined).decode()
        return DefinedProduct(product.id, product.name, defined.revision, written, by, now_s)

    def _judge_again(self, products: Sequence[Wanted]) -> None:
        """Refuse what does not fit any more; a file is refused as it is, as to judge it would hold the event loop."""
        if len(products) > 1:
            raise _ChangedError(products[0].product.id)
        for found in self.faults(products):
            if found:
                raise unusable(*found)

    async def _take_all(self, products: Sequence[Wanted], rows: Sequence[DefinedProduct]) -> None:
        """Go by definitions that fit this plant, a batch at a time: the event loop has other work, too."""
        for at in range(0, len(rows), BATCH):
            batch = products[at : at + BATCH]
            self._projection.site.define_all([(each.product, each.machines) for each in batch])
            for each, row in zip(batch, rows[at : at + BATCH], strict=True):
                self._note(row, msgspec.json.decode(row.definition, type=ProductDefinition), each.product)
            await asyncio.sleep(0)

    def _note(self, row: DefinedProduct, definition: ProductDefinition, product: Product) -> None:
        self._defined[row.id] = definition
        self._projection.materials.note(row.id, [line.material for line in product.bill])

    def _take(self, row: DefinedProduct) -> None:
        """Go by a definition; one that fits this plant no longer is left out, and said so."""
        defined = msgspec.json.decode(row.definition, type=ProductDefinition)
        product = Product(
            id=row.id,
            name=row.name,
            lot=defined.lot,
            bill=tuple(PlantLine(line.material, line.quantity) for line in defined.bill),
            ability=defined.ability,
        )
        cycles_s = {each.machine: each.cycle_s for each in defined.machines}
        found = self._projection.site.define(product, cycles_s)
        if found:
            said = "; ".join(f"{field}: {reason}" for field, reason in found)
            _log.error("product %s cannot be made in this plant: %s", row.id, said)
            return
        self._note(row, defined, product)


class _ChangedError(Exception):
    """Undoes a transaction: somebody has changed a product meanwhile."""

    def __init__(self, product: str) -> None:
        self.product = product
        super().__init__(product)


async def _define(work: Work, row: DefinedProduct) -> None:
    if not await work.products.define(row):
        raise _ChangedError(row.id)
