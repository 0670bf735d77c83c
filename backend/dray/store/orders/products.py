"""Products in SQL: what orders may name."""

from __future__ import annotations

from collections.abc import Iterable

from sqlalchemy import bindparam, select, update
from sqlalchemy.ext.asyncio import AsyncConnection

from dray.plant.model import Product
from dray.store.database.dialect import insert_new
from dray.store.tables import products


class Products:
    """The products, inside one transaction."""

    def __init__(self, connection: AsyncConnection) -> None:
        self._connection = connection

    async def replace(self, made: Iterable[Product]) -> None:
        """Let these be the products of the plant; others stay known, but are not made here any more."""
        rows = [{"id": product.id, "name": product.name, "made_here": True} for product in made]
        await self._connection.execute(update(products).values(made_here=False))
        if rows:
            await self._connection.execute(insert_new(self._connection, products), rows)
            await self._connection.execute(
                update(products).where(products.c.id == bindparam("known")).values(made_here=True),
                [{"known": row["id"], "name": row["name"]} for row in rows],
            )

    async def made_here(self) -> list[str]:
        """Ids of the plant's products."""
        query = select(products.c.id).where(products.c.made_here).order_by(products.c.id)
        return list((await self._connection.execute(query)).scalars())
