"""The catalogue: products that people have defined, over those of the plant file.

A definition is in SQL before it is answered. It is not published to agents: an order carries it to the
strategist through the outbox, which repeats it until answered, and a goal carries it to the machine. Other
gateways read it from SQL within seconds.
"""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Iterable, Mapping, Sequence
from http import HTTPStatus
from typing import NamedTuple

import msgspec
from msgspec.structs import replace

from dray.gateway.http.problems import Problem, unusable
from dray.gateway.http.shares import share_of, share_used
from dray.gateway.live.projection import Projection
from dray.gateway.products.drafts import Wanted
from dray.gateway.products.judging import Known, definition, faults, own_s
from dray.messages import Document, PartDefinition, ProductDefinition
from dray.plant import BillLine as PlantLine
from dray.plant import Fault, Plant, PlantFile, Product, products_faults
from dray.store import Store
from dray.store.orders.products import DefinedProduct
from dray.store.work import Work

_log = logging.getLogger(__name__)

PLANT_FILE = 1
"""Revision of products in the plant file."""

PRODUCTS_MAX = 2_000
"""Maximum definitions: with so many, adding a plant's products still is one short step of the event loop."""

PARTS = 2
"""Divisor for one caller's share: in many plants one system defines nearly all products, in one file."""


class Catalogue:
    """Products that can be ordered, and their bills of materials.

    Args:
        store: the database with the definitions.
        projection: its plant follows the definitions.
    """

    def __init__(self, store: Store, projection: Projection) -> None:
        self._store, self._projection = store, projection
        self._file = projection.site.plant
        """The plant as in its file, with the machines' own cycle times."""
        self._defined: dict[str, ProductDefinition] = {}
        self._mark = 0

    def revision(self, product: str) -> int:
        """The revision of a product that can be ordered."""
        known = self._defined.get(product)
        return PLANT_FILE if known is None else known.revision

    def definition_of(self, product: str) -> ProductDefinition | None:
        """The definition that an order for a product carries; None for one of the plant file."""
        return self._defined.get(product)

    def parts_of(self, product: str) -> tuple[PartDefinition, ...]:
        """The parts on all levels below a product that people have defined."""
        plant, found, ahead = self._projection.site.plant, dict[str, None](), [product]
        while ahead:
            known = plant.products.get(ahead.pop())
            for line in () if known is None else known.bill:
                if line.material in plant.parts and line.material not in found:
                    found[line.material] = None
                    ahead.append(line.material)
        return tuple(PartDefinition(part, self._defined[part]) for part in found if part in self._defined)

    def cycles_s(self, product: str) -> Mapping[str, float]:
        """Seconds per piece, by machine that can make the product."""
        plant = self._projection.site.plant
        return {machine: plant.cycle_s(machine, product) for machine in plant.machines_for(product)}

    def documents(self, product: str) -> tuple[Document, ...]:
        """The documents of a product; one of the plant file has none."""
        known = self._defined.get(product)
        return () if known is None else known.documents

    def own_s(self, machine: str, product: str) -> float | None:
        """A machine's own cycle time for a product; None if it gives none."""
        return own_s(self._file, machine, product)

    def known(self) -> Known:
        """The data by which new products are judged now."""
        plant = self._projection.site.plant
        revisions = {product: self.revision(product) for product in self._projection.site.products}
        return Known(msgspec.json.encode(plant.file), msgspec.json.encode(self._file.file), revisions)

    async def define(self, products: Sequence[Wanted], by: str, now_s: float, judged: Plant) -> str:
        """Store products that have no `faults`, all or none.

        Args:
            products: the new definitions.
            judged: the plant in which they were found without faults.
            by: the caller.
            now_s: wall clock.

        Returns:
            The first product that somebody else changed since, so that nothing was stored; empty on success.

        Raises:
            Problem: 422, a product conflicts with another's new definition; 429 or 409, there are too many
                new ones.
            UnavailableError: the database cannot be written.
        """
        news = [_news(each, by, now_s) for each in products]
        try:
            async with self._store.write() as work:
                # From here nobody else defines anything; the earlier judgement may be out of date.
                await self.look(work)
                if self._projection.site.plant is not judged:
                    await self._judge_again(products)
                await _refuse_too_many(work, sum(each.before is None for each in products), by)
                for each in news:
                    await _define(work, each.row)
        except _ChangedError as changed:
            return changed.product
        if self._projection.site.plant is judged:
            self._go_by(news)
        else:
            await self._take([each.row for each in news])
        return ""

    def is_news(self, wanted: Wanted) -> bool:
        """Whether a product differs from its stored definition, or has none."""
        known = self._defined.get(wanted.product.id)
        return known is None or replace(definition(wanted), revision=known.revision) != known

    async def look(self, work: Work) -> None:
        """Read definitions made since the last look; at first, all."""
        mark = await work.products.mark()
        if mark == self._mark:
            return
        news = [row for row in await work.products.defined() if self._is_later(row)]
        await self._take(news)
        self._mark = mark

    def _is_later(self, row: DefinedProduct) -> bool:
        known = self._defined.get(row.id)
        return known is None or row.revision > known.revision

    async def _judge_again(self, products: Sequence[Wanted]) -> None:
        """Refuse a product that no longer fits; a whole file is refused without a new check."""
        if len(products) > 1:
            raise _ChangedError(products[0].product.id)
        [found] = await asyncio.to_thread(faults, self._file, self._projection.site.plant.file, products)
        if found:
            raise unusable(*found)

    async def _take(self, rows: Sequence[DefinedProduct]) -> None:
        """Apply definitions that fit this plant; one that no longer fits is skipped and logged."""
        if not rows:
            return
        # Judging a whole plant happens outside the loop: all at once, and in halves only if there is a fault.
        news, found = await asyncio.to_thread(_judged, self._projection.site.plant.file, rows)
        if not found:
            self._go_by(news)
        elif len(rows) == 1:
            said = "; ".join(f"{field}: {reason}" for field, reason in found)
            _log.error("product %s cannot be made in this plant: %s", rows[0].id, said)
        else:
            half = len(rows) // 2
            await self._take(rows[:half])
            await self._take(rows[half:])

    def _go_by(self, news: Iterable[_News]) -> None:
        """Apply definitions that fit this plant, unless newer ones have arrived."""
        later = [each for each in news if self._is_later(each.row)]
        self._projection.site.define([(each.product, each.cycles_s) for each in later])
        for each in later:
            self._defined[each.row.id] = each.definition
            self._projection.materials.note(each.row.id, [line.material for line in each.product.bill])


class _News(NamedTuple):
    """A definition to apply."""

    row: DefinedProduct
    definition: ProductDefinition
    product: Product
    cycles_s: Mapping[str, float]


def _news(wanted: Wanted, by: str, now_s: float) -> _News:
    product, defined = wanted.product, definition(wanted)
    written = msgspec.json.encode(defined).decode()
    row = DefinedProduct(product.id, product.name, defined.revision, written, by, now_s)
    return _News(row, defined, product, wanted.machines)


def _judged(file: PlantFile, rows: Iterable[DefinedProduct]) -> tuple[list[_News], list[Fault]]:
    """Stored definitions, decoded, and their faults in a plant."""
    news = [_read(row) for row in rows]
    return news, products_faults(file, [(each.product, each.cycles_s) for each in news])


def _read(row: DefinedProduct) -> _News:
    defined = msgspec.json.decode(row.definition, type=ProductDefinition)
    product = Product(
        id=row.id,
        name=row.name,
        lot=defined.lot,
        bill=tuple(PlantLine(line.material, line.quantity) for line in defined.bill),
        ability=defined.ability,
    )
    return _News(row, defined, product, {each.machine: each.cycle_s for each in defined.machines})


async def _refuse_too_many(work: Work, new: int, by: str) -> None:
    """Refuse more new products than one caller, or all together, may define.

    Raises:
        Problem: 429 or 409.
    """
    if not new:
        return
    own, everybodys = await work.products.counted(by)
    do = "change one that is not made any more instead of defining another one (GET /api/products lists them)"
    if own + new > share_of(PRODUCTS_MAX, PARTS):
        raise share_used("defined products", PRODUCTS_MAX, do, again_s=None, parts=PARTS)
    if everybodys + new > PRODUCTS_MAX:
        raise Problem(
            HTTPStatus.CONFLICT,
            "too-many-products",
            "There are too many products",
            f"{PRODUCTS_MAX} may be defined: {do}",
        )


class _ChangedError(Exception):
    """Rolls back a transaction: somebody else has changed a product."""

    def __init__(self, product: str) -> None:
        self.product = product
        super().__init__(product)


async def _define(work: Work, row: DefinedProduct) -> None:
    if not await work.products.define(row):
        raise _ChangedError(row.id)
