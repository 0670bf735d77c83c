"""Customers' links in SQL: whoever has one may see one order's page, until it ends.

A link is looked up by the SHA-256 of its token, through a unique index: how long the look-up takes tells
nothing about any token, and a link that was made by hand can be read nowhere. The token that came with an
order is also kept with the order itself, because the answer to a repeated request names it again; who may
read that table may read all that the page could tell.
"""

from __future__ import annotations

import msgspec
from sqlalchemy import delete, insert, select, update
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

    def works(self, now_s: float) -> bool:
        """Whether nobody has taken it back, and its own time is not over."""
        return self.revoked_at_s is None and (self.expires_at_s is None or now_s < self.expires_at_s)


WORKING_MAX = 50
"""Links of one order that lead to its page at once: more than it has readers."""

ENDED_KEPT = 50
"""Ended links of one order whose pages say that they have ended; older ones are forgotten."""


class Links:
    """The links, inside one transaction."""

    def __init__(self, connection: AsyncConnection) -> None:
        self._connection = connection

    async def add(self, token: str, link: Link) -> None:
        """Keep a new link."""
        row = msgspec.structs.asdict(link)
        await self._connection.execute(insert(tracking_links), [{"token_hash": digest(token), **row}])

    async def add_another(self, token: str, link: Link) -> bool:
        """Keep another link to an order's page; False when it has as many as may be."""
        known = await self.of_order(link.order_id)
        if sum(each.works(link.created_at_s) for each in known) >= WORKING_MAX:
            return False
        await self.add(token, link)
        await self._forget_ended(link.order_id, link.created_at_s)
        return True

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

    async def _forget_ended(self, order_id: str, now_s: float) -> None:
        columns = tracking_links.c
        ended = columns.revoked_at_s.is_not(None) | (columns.expires_at_s <= now_s)
        newest_first = (columns.created_at_s.desc(), columns.token_hash)
        query = select(columns.token_hash).where(columns.order_id == order_id, ended).order_by(*newest_first)
        found = list((await self._connection.execute(query)).scalars())
        if oldest := found[ENDED_KEPT:]:
            await self._connection.execute(delete(tracking_links).where(columns.token_hash.in_(oldest)))

    async def _revoke(self, condition: object, at_s: float) -> int:
        done = await self._connection.execute(
            update(tracking_links)
            .where(condition, tracking_links.c.revoked_at_s.is_(None))  # type: ignore[arg-type]
            .values(revoked_at_s=at_s)
        )
        return done.rowcount
