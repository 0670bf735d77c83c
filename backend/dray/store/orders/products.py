"""Products in SQL, which orders may name."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from typing import NamedTuple

import msgspec
from sqlalchemy import (
    CompoundSelect,
    Select,
    and_,
    bindparam,
    case,
    delete,
    exists,
    func,
    select,
    union,
    update,
)
from sqlalchemy.ext.asyncio import AsyncConnection

from dray.plant.model import Product
from dray.store.database.dialect import insert_new
from dray.store.orders.progress import UNENDED
from dray.store.orders.transports import open_with
from dray.store.tables import goals, order_items, orders, products

REMOVED_KEPT = 2_000
"""Removed products that are remembered although no order names them: as many as may be defined. They keep the number of their
last revision, so that one who defines such a product again does not repeat it."""

TICK_S = 1e-3
"""Least time between two changes of the products in wall seconds, so that the newest change has a time of its own."""


class DefinedProduct(msgspec.Struct, frozen=True, gc=False):
    """A product defined by people."""

    id: str
    name: str
    revision: int
    """The revision: one higher with every change; a product of the plant file begins with 1."""
    definition: str
    """JSON of a `ProductDefinition`; empty in SQL for the plant file's definition."""
    by: str
    """The author of the last change."""
    at_s: float
    """The time of the last change; wall clock."""


class RemovedProduct(msgspec.Struct, frozen=True, gc=False):
    """A product that cannot be ordered any more: people have removed it, or the plant file has lost it."""

    id: str
    name: str
    revision: int
    """The revision of its end; a new definition has the next one."""
    by: str
    """Who removed it; empty if the plant file has lost it."""
    at_s: float
    """The time of its removal; 0 if the plant file has lost it."""


class AuthoredProduct(msgspec.Struct, frozen=True, gc=False):
    """A product that people have defined, or removed."""

    id: str
    name: str
    revision: int
    by: str
    at_s: float
    defined: bool
    """Whether it was not removed."""


class Mark(NamedTuple):
    """A value that changes with every definition and every removal."""

    revisions: int
    at_s: float


class Needing(NamedTuple):
    """What needs a product: the first of its kind, and their number."""

    first: tuple[str, ...]
    how_many: int


_REMOVED = [products.c[name] for name in RemovedProduct.__struct_fields__]

_GONE = and_(products.c.definition == "", ~products.c.made_here)
"""A product that cannot be ordered any more."""

_REMOVED_BY_PEOPLE = and_(_GONE, products.c.by != "")

_COLUMNS = [products.c[name] for name in DefinedProduct.__struct_fields__]


class Products:
    """The products, inside one transaction."""

    def __init__(self, connection: AsyncConnection) -> None:
        self._connection = connection

    async def replace(self, made: Iterable[Product]) -> None:
        """Set the products of the plant; others stay known, but are not made here any more."""
        rows = [{"id": product.id, "name": product.name, "made_here": True} for product in made]
        await self._connection.execute(update(products).values(made_here=False))
        if rows:
            await self._connection.execute(insert_new(self._connection, products), rows)
            await self._connection.execute(
                update(products)
                .where(products.c.id == bindparam("known"))
                # One that people had removed before it came into the plant file begins anew there.
                .values(
                    made_here=True, revision=case((products.c.definition == "", 1), else_=products.c.revision)
                ),
                [{"known": row["id"], "name": row["name"]} for row in rows],
            )

    async def defined(self) -> list[DefinedProduct]:
        """The products defined by people, by id."""
        query = select(*_COLUMNS).where(products.c.definition != "").order_by(products.c.id)
        return [DefinedProduct(*row) for row in await self._connection.execute(query)]

    async def authored(self) -> list[AuthoredProduct]:
        """The products defined by people, without their definitions, by id."""
        query = select(*_REMOVED).where(products.c.definition != "").order_by(products.c.id)
        rows = (await self._connection.execute(query)).mappings()
        return [AuthoredProduct(**row, defined=True) for row in rows]

    async def removed_by_people(self) -> list[AuthoredProduct]:
        """The last `REMOVED_KEPT` products that people have removed, by id."""
        query = select(*_REMOVED).where(_REMOVED_BY_PEOPLE)
        query = query.order_by(products.c.at_s.desc(), products.c.id).limit(REMOVED_KEPT)
        rows = (await self._connection.execute(query)).mappings()
        found = [AuthoredProduct(**row, defined=False) for row in rows]
        return sorted(found, key=lambda product: product.id)

    async def removed(self, most: int) -> list[RemovedProduct]:
        """Products that cannot be ordered any more, the last removed first."""
        query = select(*_REMOVED).where(_GONE).order_by(products.c.at_s.desc(), products.c.id).limit(most)
        return [RemovedProduct(*row) for row in await self._connection.execute(query)]

    async def revisions(self, ids: Collection[str], *, defined: bool = False) -> dict[str, int]:
        """Revisions of those of these that are known, or only of those that people have defined."""
        query = select(products.c.id, products.c.revision).where(products.c.id.in_(sorted(ids)))
        if defined:
            query = query.where(products.c.definition != "")
        return {row.id: row.revision for row in await self._connection.execute(query)}

    async def mark(self) -> Mark:
        """A value that changes with every definition and every removal."""
        # The time alone would do, if no older version of this program, which gives any time, were writing beside this one.
        query = select(func.coalesce(func.sum(products.c.revision), 0), func.max(products.c.at_s))
        revisions, at_s = (await self._connection.execute(query)).one()
        return Mark(int(revisions), float(at_s or 0.0))

    async def next_s(self, now_s: float) -> float:
        """The time of a change that is made now: later than all before it, whatever another clock said."""
        newest_s = (await self._connection.execute(select(func.max(products.c.at_s)))).scalar()
        return max(now_s, (newest_s or 0.0) + TICK_S)

    async def counted(self, by: str) -> tuple[int, int]:
        """How many people have defined: this one last, and all together."""
        own = func.count().filter(products.c.by == by)
        query = select(own, func.count()).where(products.c.definition != "")
        mine, everybodys = (await self._connection.execute(query)).one()
        return int(mine), int(everybodys)

    async def define(self, product: DefinedProduct) -> bool:
        """Store a definition, if the stored revision is the previous one; returns whether it was."""
        row = {**msgspec.structs.asdict(product), "made_here": True}
        if product.revision == 1:
            insertion = insert_new(self._connection, products).values(row)
            return bool((await self._connection.execute(insertion)).rowcount)
        done = await self._connection.execute(
            update(products)
            .where(products.c.id == product.id, products.c.revision == product.revision - 1)
            .values(row)
        )
        return bool(done.rowcount)

    async def remove(self, ids: Collection[str], by: str, at_s: float) -> None:
        """Remove definitions: their names stay, for the orders' sake.

        Those that no order names are forgotten, too, when `REMOVED_KEPT` others were removed after them.

        Args:
            ids: products that people have defined, and that nothing needs.
            by: the author.
            at_s: as of `next_s`.
        """
        c = products.c
        gone = {"definition": "", "made_here": False, "revision": c.revision + 1, "by": by, "at_s": at_s}
        await self._connection.execute(
            update(products).where(c.id.in_(sorted(ids)), c.definition != "").values(gone)
        )
        named = exists().where(order_items.c.product == c.id)
        unnamed = select(c.id).where(_REMOVED_BY_PEOPLE, ~named)
        oldest = unnamed.order_by(c.at_s.desc(), c.id).offset(REMOVED_KEPT).limit(REMOVED_KEPT)
        too_old = list((await self._connection.execute(oldest)).scalars())
        if too_old:
            await self._connection.execute(delete(products).where(c.id.in_(too_old)))

    async def orders_needing(self, ids: Collection[str], most: int) -> dict[str, Needing]:
        """Orders that have not ended and name one of these, or for which one of these is made, as part of another one.

        Args:
            ids: the products.
            most: how many are named of each product.
        """
        unended = select(orders.c.id).where(orders.c.status.in_([status.value for status in UNENDED]))
        lines = select(order_items.c.product, order_items.c.order_id.label("of"))
        lines = lines.where(order_items.c.product.in_(sorted(ids)), order_items.c.order_id.in_(unended))
        made = select(goals.c.product, goals.c.order_id.label("of"))
        made = made.where(goals.c.product.in_(sorted(ids)), goals.c.order_id.in_(unended))
        return await self._needing(union(lines, made), most)

    async def transports_needing(self, ids: Collection[str], most: int) -> dict[str, Needing]:
        """Plain transports of these that have not ended, as of `orders_needing`."""
        return await self._needing(open_with(ids), most)

    async def _needing(
        self, pairs: Select[str, str] | CompoundSelect[str, str], most: int
    ) -> dict[str, Needing]:
        each = pairs.subquery()
        place = func.row_number().over(partition_by=each.c.product, order_by=each.c.of)
        count = func.count().over(partition_by=each.c.product)
        ranked = select(each.c.product, each.c.of, place.label("place"), count.label("count")).subquery()
        query = select(ranked).where(ranked.c.place <= most).order_by(ranked.c.product, ranked.c.place)
        found: dict[str, Needing] = {}
        for product, of, _, how_many in await self._connection.execute(query):
            before = found.get(product)
            found[product] = Needing((*(before.first if before else ()), of), how_many)
        return found

    async def made_here(self) -> list[str]:
        """Ids of the plant's products."""
        query = select(products.c.id).where(products.c.made_here).order_by(products.c.id)
        return list((await self._connection.execute(query)).scalars())
