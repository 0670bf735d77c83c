"""The catalogue: products that people have defined, over those of the plant file.

A definition is in SQL before it is answered. It is not published to agents: an order carries it to the
strategist through the outbox, which repeats it until answered, and a goal carries it to the machine. Other
gateways read it from SQL within seconds.

So a removal needs no message either: nothing that is open needs the product, and no agent keeps a table of products.
SQL alone says what there is. Every gateway compares its memory with it, and whoever was away reads it at the start.
"""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Collection, Iterable, Mapping, Sequence
from collections.abc import Set as AbstractSet
from http import HTTPStatus
from typing import NamedTuple

import msgspec
from msgspec.structs import replace

from dray.gateway.http.problems import Problem, unusable
from dray.gateway.http.shares import share_of, share_used
from dray.gateway.live.projection import Projection
from dray.gateway.products.drafts import Wanted
from dray.gateway.products.judging import Known, definition, faults, own_s
from dray.gateway.products.needs import NAMED_MAX, Kept, Need, NeedKind, needing, schedules_needing, users_of
from dray.messages import Document, PartDefinition, ProductDefinition
from dray.plant import BillLine as PlantLine
from dray.plant import Fault, Plant, PlantFile, Product, file_without_products, products_faults
from dray.store import Store
from dray.store.orders.products import REMOVED_KEPT, DefinedProduct, Mark, Needing
from dray.store.work import Work

_log = logging.getLogger(__name__)

PLANT_FILE = 1
"""Revision of products in the plant file."""

PRODUCTS_MAX = 2_000
"""Maximum definitions: with so many, adding a plant's products still is one short step of the event loop."""

FORMER_MAX = REMOVED_KEPT
"""Maximum products that cannot be ordered any more whose names are in memory; the last removed."""

PARTS = 2
"""Divisor for one caller's share: in many plants one system defines nearly all products, in one file."""


NEVER = Mark(-1, 0.0)
"""The mark of no database: the next look reads all."""


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
        self._mark = NEVER
        self._looks: list[set[str]] = []
        """Per look under way, the products that have changed here since it began: what it has read may be older."""
        self._removing: AbstractSet[str] = frozenset()
        """Products whose removal is being written."""

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
        try:
            async with self._store.write() as work:
                # From here nobody else defines anything; the earlier judgement may be out of date.
                await self.look(work)
                if self._projection.site.plant is not judged:
                    await self._judge_again(products)
                new = [each.product.id for each in products if each.before is None]
                await _refuse_too_many(work, len(new), by)
                # Of those that nobody can order here: removed ones, and those that do not fit this plant any more.
                lasts = await work.products.revisions(set(new) - self._projection.site.products)
                at_s = await work.products.next_s(now_s)
                news = [_news(each, lasts.get(each.product.id), by, at_s) for each in products]
                for each in news:
                    await _define(work, each.row)
        except _ChangedError as changed:
            return changed.product
        if self._projection.site.plant is judged:
            self._go_by([each for each in news if self._is_later(each.row)])
        else:
            await self._take([each.row for each in news])
        self._mark = NEVER
        return ""

    def is_news(self, wanted: Wanted) -> bool:
        """Whether a product differs from its stored definition, or has none."""
        known = self._defined.get(wanted.product.id)
        return known is None or replace(definition(wanted), revision=known.revision) != known

    async def lasts(self, ids: Collection[str]) -> dict[str, int]:
        """Of these, the last revisions of those that cannot be ordered any more; a new definition has the next one.

        Raises:
            UnavailableError: the database cannot be read.
        """
        async with self._store.read() as work:
            return await work.products.revisions(set(ids) - self._projection.site.products)

    async def remove(
        self, ids: Collection[str], by: str, now_s: float, *, revision: int | None = None
    ) -> dict[str, Kept]:
        """Remove products that people have defined: those that nothing needs.

        Args:
            ids: the products. One that only others of them need is removed with these.
            by: the caller.
            now_s: wall clock.
            revision: the one that the caller has read; None for any.

        Returns:
            The products that are not removed, by id, with what keeps them.

        Raises:
            UnavailableError: the database cannot be written.
        """
        try:
            async with self._store.write() as work:
                # From here nobody else defines, orders or removes anything in this database.
                await self.look(work)
                defined = await work.products.revisions(ids, defined=True)
                kept = {id_: why for id_ in ids if (why := self._unremovable(id_, defined, revision))}
                needs = await self._needs(work, set(ids) - kept.keys())
                kept |= {id_: Kept("needed", why) for id_, why in needs.items()}
                if gone := set(ids) - kept.keys():
                    await work.products.remove(gone, by, await work.products.next_s(now_s))
                    former = await _former(work)
                    # Before it is on disk: no order is prepared in between that would need them.
                    self._removing = gone
                    self._go_by([], gone)
                    self._projection.site.former = former
        finally:
            # If it was not written after all, the next look brings them back.
            self._removing, self._mark = frozenset(), NEVER
        return kept

    def _unremovable(self, product: str, defined: Mapping[str, int], revision: int | None) -> Kept | None:
        """Why a product cannot be removed, whatever needs it; None for no reason."""
        if product in self._file.products:
            return Kept("in_plant_file")
        if product not in defined:
            return Kept("unknown")
        return None if revision in (None, defined[product]) else Kept("changed")

    async def _needs(self, work: Work, ids: AbstractSet[str]) -> dict[str, tuple[Need, ...]]:
        """What needs these products, by product; those that nothing needs are left out."""
        if not ids:
            return {}
        sources: dict[NeedKind, dict[str, Needing]] = {
            "order": await work.products.orders_needing(ids, NAMED_MAX),
            "transport": await work.products.transports_needing(ids, NAMED_MAX),
            "schedule": await asyncio.to_thread(
                schedules_needing, await work.schedules.contents(), frozenset(ids)
            ),
            "machine": self._machines_needing(ids),
        }
        needs: dict[str, list[Need]] = {}
        for kind, found in sources.items():
            for product, some in found.items():
                needs.setdefault(product, []).append(Need(kind, *some))
        file = self._projection.site.plant.file
        for product, users in (await asyncio.to_thread(users_of, file, ids, frozenset(needs))).items():
            needs.setdefault(product, []).append(Need("product", *users))
        return {product: tuple(found) for product, found in needs.items()}

    def _machines_needing(self, ids: AbstractSet[str]) -> dict[str, Needing]:
        """Machines with goals of these products, by their last heartbeats, or that have joined and make them by themselves."""
        found: dict[str, list[str]] = {}
        for heartbeat, _ in self._projection.machines.heartbeats():
            for product in ids & {goal.product for goal in heartbeat.goals}:
                found.setdefault(product, []).append(heartbeat.machine)
        for machine in self._projection.site.plant.file.machines:
            if machine.id not in self._file.machines:
                for product in ids & {making.product for making in machine.makes}:
                    found.setdefault(product, []).append(machine.id)
        return {product: needing(machines) for product, machines in found.items()}

    async def look(self, work: Work) -> None:
        """Read definitions and removals made since the last look; at first, all."""
        meanwhile = set(self._removing)
        self._looks.append(meanwhile)
        try:
            mark = await work.products.mark()
            if mark == self._mark:
                return
            stored = {row.id: row for row in await work.products.defined()}
            former = await _former(work)
            gone = self._defined.keys() - stored.keys()
            await self._take([row for row in stored.values() if self._is_news(row)], gone, meanwhile)
            self._projection.site.former = former
            # What has changed meanwhile is read again.
            self._mark = NEVER if meanwhile else mark
        finally:
            # By identity: two looks may have seen the same changes.
            self._looks = [each for each in self._looks if each is not meanwhile]

    async def recall(self, work: Work) -> None:
        """Read the names of products that cannot be ordered any more."""
        self._projection.site.former = await _former(work)

    def _is_news(self, row: DefinedProduct) -> bool:
        known = self._defined.get(row.id)
        return known is None or row.revision != known.revision

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

    async def _take(
        self,
        rows: Sequence[DefinedProduct],
        gone: AbstractSet[str] = frozenset(),
        meanwhile: AbstractSet[str] = frozenset(),
    ) -> None:
        """Apply what was read: definitions that fit this plant, and removals.

        A definition that does not fit any more is skipped and logged; so are removals of what the rest of the plant still needs.

        Args:
            rows: the definitions.
            gone: the removed products.
            meanwhile: products that have changed here since this was read; they stay as they are.
        """
        if not rows and not gone:
            return
        # Judging a whole plant happens outside the loop: all at once, and in halves only if there is a fault.
        news, found = await asyncio.to_thread(_judged, self._projection.site.plant.file, rows, gone)
        if not found:
            self._go_by([each for each in news if each.row.id not in meanwhile], gone - meanwhile, meanwhile)
        elif gone and not rows:
            _log.error("removed products stay in this plant until a restart: %s", ", ".join(sorted(gone)))
        elif len(rows) == 1 and not gone:
            said = "; ".join(f"{field}: {reason}" for field, reason in found)
            _log.error("product %s cannot be made in this plant: %s", rows[0].id, said)
        else:
            half = (len(rows) + 1) // 2
            await self._take(rows[:half], meanwhile=meanwhile)
            await self._take(rows[half:], meanwhile=meanwhile)
            await self._take((), gone, meanwhile)

    def _go_by(
        self, news: Sequence[_News], gone: Collection[str] = (), look: AbstractSet[str] | None = None
    ) -> None:
        """Apply definitions that fit this plant, and removals.

        Args:
            news: the definitions.
            gone: the removed products.
            look: the changes seen by the look that has read this; None for a change of our own.
        """
        known = [product for product in gone if product in self._defined]
        if not news and not known:
            return
        for other in self._looks:
            if other is not look:
                other.update(known, (each.row.id for each in news))
        self._projection.site.change_products([(each.product, each.cycles_s) for each in news], known)
        for product in known:
            del self._defined[product]
            self._projection.materials.forget(product)
        for each in news:
            self._defined[each.row.id] = each.definition
            self._projection.materials.note(each.row.id, [line.material for line in each.product.bill])


async def _former(work: Work) -> dict[str, str]:
    return {each.id: each.name for each in await work.products.removed(FORMER_MAX)}


class _News(NamedTuple):
    """A definition to apply."""

    row: DefinedProduct
    definition: ProductDefinition
    product: Product
    cycles_s: Mapping[str, float]


def _news(wanted: Wanted, last: int | None, by: str, now_s: float) -> _News:
    """A definition to apply.

    Args:
        wanted: as asked for.
        last: the last revision of a product of its id that cannot be ordered any more; None for none.
        by: the caller.
        now_s: wall clock.
    """
    product, defined = wanted.product, definition(wanted)
    if last is not None:
        defined = replace(defined, revision=last + 1)
    written = msgspec.json.encode(defined).decode()
    row = DefinedProduct(product.id, product.name, defined.revision, written, by, now_s)
    return _News(row, defined, product, wanted.machines)


def _judged(
    file: PlantFile, rows: Iterable[DefinedProduct], gone: Collection[str]
) -> tuple[list[_News], list[Fault]]:
    """Stored definitions, decoded, and their faults in a plant without those that are gone."""
    news = [_read(row) for row in rows]
    return news, products_faults(
        file_without_products(file, gone), [(each.product, each.cycles_s) for each in news]
    )


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
    do = "remove those that are not made any more (GET /api/products lists them, POST /api/products/remove removes several)"
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
