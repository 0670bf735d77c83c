"""Customers' links in SQL: whoever has one may see one order's page, until it ends.

A link is looked up by the SHA-256 of its token, through a unique index: how long the look-up takes tells
nothing about any token, and a link that was made by hand can be read nowhere. The token that came with an
order is also kept with the order itself, because the answer to a repeated request names it again; who may
read that table may read all that the page could tell.
"""

from __future__ import annotations

import msgspec
from sqlalchemy import insert, select, update
from sqlalchemy.ext.asyncio import AsyncConnection

from dray.store.access.digest import digest
from dray.store.tables import tracking_links


class Link(msgspec.Struct, frozen=True, gc=False):
    """A link to an order's page. Times are wall clock seconds."""

    order_id: str
    created_at_s: float
    expires_at_s: float | None = None
    """None: it ends some time after the order has."""
    revoked_at_s: float | None = None


class Links:
    """The links, inside one transaction."""

    def __init__(self, connection: AsyncConnection) -> None:
        self._connection = connection

    async def add(self, token: str, link: Link) -> None:
        """Keep a new link."""
        row = msgspec.structs.asdict(link)
        await self._connection.execute(insert(tracking_links), [{"token_hash": digest(token), **row}])

    async def find(self, token: str) -> Link | None:
        """The link with this token, ended or not; None when there never was one."""
        columns = [tracking_links.c[name] for name in Link.__struct_fields__]
        query = select(*columns).where(tracking_links.c.token_hash == digest(token))
        row = (await self._connection.execute(query)).one_or_none()
        return None if row is None else Link(**row._mapping)  # noqa: SLF001 - SQLAlchemy's public name

    async def of_order(self, order_id: str) -> list[Link]:
        """All links to the page of an order, ended ones too, newest first."""
        columns = [tracking_links.c[name] for name in Link.__struct_fields__]
        query = select(*columns).where(tracking_links.c.order_id == order_id)
        rows = await self._connection.execute(query.order_by(tracking_links.c.created_at_s.desc()))
        return [Link(**row._mapping) for row in rows]  # noqa: SLF001 - SQLAlchemy's public name

    async def revoke(self, token: str, at_s: float) -> int:
        """Take one link back; returns how many were taken back by this: 0 or 1."""
        return await self._revoke(tracking_links.c.token_hash == digest(token), at_s)

    async def revoke_all(self, order_id: str, at_s: float) -> int:
        """Take back all links of an order; returns how many were taken back by this."""
        return await self._revoke(tracking_links.c.order_id == order_id, at_s)

    async def _revoke(self, condition: object, at_s: float) -> int:
        done = await self._connection.execute(
            update(tracking_links)
            .where(condition, tracking_links.c.revoked_at_s.is_(None))  # type: ignore[arg-type]
            .values(revoked_at_s=at_s)
        )
        return done.rowcount
