"""Products in SQL, which orders may name."""

from __future__ import annotations

from collections.abc import Iterable

import msgspec
from sqlalchemy import bindparam, func, select, update
from sqlalchemy.ext.asyncio import AsyncConnection

from dray.plant.model import Product
from dray.store.database.dialect import insert_new
from dray.store.tables import products


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
                update(products).where(products.c.id == bindparam("known")).values(made_here=True),
                [{"known": row["id"], "name": row["name"]} for row in rows],
            )

    async def defined(self) -> list[DefinedProduct]:
        """The products defined by people, by id."""
        query = select(*_COLUMNS).where(products.c.definition != "").order_by(products.c.id)
        return [DefinedProduct(*row) for row in await self._connection.execute(query)]

    async def mark(self) -> int:
        """A number that changes with every definition."""
        query = select(func.coalesce(func.sum(products.c.revision), 0)).where(products.c.definition != "")
        return int((await self._connection.execute(query)).scalar_one())

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

    async def made_here(self) -> list[str]:
        """Ids of the plant's products."""
        query = select(products.c.id).where(products.c.made_here).order_by(products.c.id)
        return list((await self._connection.execute(query)).scalars())
