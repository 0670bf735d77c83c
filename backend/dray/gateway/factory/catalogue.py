"""The catalogue: products as people have defined them, over those of the plant file.

A definition is in SQL before it is answered. It needs no announcement to agents: an order brings it to the strategist, by the outbox, which says
it until it is answered, and a goal brings it to the machine. Other gateways find it in SQL within seconds.
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
"""The revision of what stands in the plant file."""

PRODUCTS_MAX = 2_000
"""Definitions that are kept: with so many a plant is still taken in within one short step of the event loop."""

PARTS = 2
"""In which the bound is cut: one system defines nearly all products of many plants, and one file has as many as one caller may define."""


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
            Problem: 422, one does not fit any more with what others have defined meanwhile; 429 or 409, there are too many new ones.
            UnavailableError: the database cannot be written.
        """
        news = [_news(each, by, now_s) for each in products]
        try:
            async with self._store.write() as work:
                # From here on nobody else defines anything: what was found good may not be so any more.
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
        """Whether a product is to be otherwise than it is, where people have defined it; that is so of all others."""
        known = self._defined.get(wanted.product.id)
        return known is None or replace(definition(wanted), revision=known.revision) != known

    async def look(self, work: Work) -> None:
        """Learn what was defined since the last look; at the first one, all of it."""
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
        """Refuse what does not fit any more; a file is refused as it is."""
        if len(products) > 1:
            raise _ChangedError(products[0].product.id)
        [found] = await asyncio.to_thread(faults, self._file, self._projection.site.plant.file, products)
        if found:
            raise unusable(*found)

    async def _take(self, rows: Sequence[DefinedProduct]) -> None:
        """Go by definitions as far as they fit this plant; one that does not any more is left out, and said so."""
        if not rows:
            return
        # A whole plant is judged, beside the loop: all of them together, and only where something is wrong, parts of them.
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
        """Go by definitions that fit this plant, unless later ones have come meanwhile."""
        later = [each for each in news if self._is_later(each.row)]
        self._projection.site.define([(each.product, each.cycles_s) for each in later])
        for each in later:
            self._defined[each.row.id] = each.definition
            self._projection.materials.note(each.row.id, [line.material for line in each.product.bill])


class _News(NamedTuple):
    """A definition that is to be gone by."""

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
    """What was kept, read, and what of it does not fit into a plant."""
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
    """Refuse more new products than a caller, or all of them together, may define.

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
    """Undoes a transaction: somebody has changed a product meanwhile."""

    def __init__(self, product: str) -> None:
        self.product = product
        super().__init__(product)


async def _define(work: Work, row: DefinedProduct) -> None:
    if not await work.products.define(row):
        raise _ChangedError(row.id)
