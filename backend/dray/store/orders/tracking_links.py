"""Customers' links in SQL: each gives access to the page of one order or plain transport, until it ends.

A link is looked up by the SHA-256 of its token, through a unique index. So the duration of the look-up reveals nothing about any
token. A link made by hand is stored nowhere in clear. The token that came with an order is also stored with the order, because
the answer to a repeated request contains it. A reader of that table may read everything on the page anyway.
"""

from __future__ import annotations

import msgspec
from sqlalchemy import ColumnElement, Table, delete, insert, select, update
from sqlalchemy.ext.asyncio import AsyncConnection

from dray.store.access.digest import digest


class Link(msgspec.Struct, frozen=True, gc=False):
    """A link to a page. Times are wall clock seconds."""

    subject: str
    """The order, or the transport."""
    created_at_s: float
    expires_at_s: float | None = None
    """None: it ends some time after its subject's end."""
    revoked_at_s: float | None = None

    def works(self, now_s: float) -> bool:
        """Whether it is neither revoked nor expired."""
        return self.revoked_at_s is None and (self.expires_at_s is None or now_s < self.expires_at_s)


TIMES = ("created_at_s", "expires_at_s", "revoked_at_s")

WORKING_MAX = 50
"""Maximum working links to one page: more than it has readers."""

ENDED_KEPT = 50
"""Maximum ended links to one page that still report their end; older ones are deleted."""


class Links:
    """The links to pages of one kind, inside one transaction.

    Args:
        connection: the transaction's connection.
        table: their table.
        subject: the column of the order or transport.
    """

    def __init__(self, connection: AsyncConnection, table: Table, subject: str) -> None:
        self._connection, self._table, self._subject = connection, table, table.c[subject]
        self._columns = [self._subject.label("subject"), *(table.c[name] for name in TIMES)]

    async def add(self, token: str, link: Link) -> None:
        """Store a new link."""
        times = {name: getattr(link, name) for name in TIMES}
        row = {"token_hash": digest(token), self._subject.name: link.subject, **times}
        await self._connection.execute(insert(self._table), [row])

    async def add_another(self, token: str, link: Link) -> bool:
        """Store another link to a page; False at the maximum."""
        known = await self.to(link.subject)
        if sum(each.works(link.created_at_s) for each in known) >= WORKING_MAX:
            return False
        await self.add(token, link)
        await self._forget_ended(link.subject, link.created_at_s)
        return True

    async def find(self, token: str) -> Link | None:
        """The link with this token, ended or not; None for an unknown token."""
        query = select(*self._columns).where(self._table.c.token_hash == digest(token))
        row = (await self._connection.execute(query)).first()
        return None if row is None else Link(**row._mapping)  # noqa: SLF001 - SQLAlchemy's public name

    async def to(self, subject: str) -> list[Link]:
        """All links to the page of an order or transport, ended ones too, newest first."""
        query = select(*self._columns).where(self._subject == subject)
        rows = await self._connection.execute(query.order_by(self._table.c.created_at_s.desc()))
        return [Link(**row._mapping) for row in rows]  # noqa: SLF001 - SQLAlchemy's public name

    async def revoke(self, token: str, at_s: float) -> int:
        """Revoke one link; returns the number revoked by this: 0 or 1."""
        return await self._revoke(self._table.c.token_hash == digest(token), at_s)

    async def revoke_all(self, subject: str, at_s: float) -> int:
        """Revoke all links to a page; returns the number revoked by this."""
        return await self._revoke(self._subject == subject, at_s)

    async def _forget_ended(self, subject: str, now_s: float) -> None:
        columns = self._table.c
        ended = columns.revoked_at_s.is_not(None) | (columns.expires_at_s <= now_s)
        newest_first = (columns.created_at_s.desc(), columns.token_hash)
        query = select(columns.token_hash).where(self._subject == subject, ended).order_by(*newest_first)
        found = list((await self._connection.execute(query)).scalars())
        if oldest := found[ENDED_KEPT:]:
            await self._connection.execute(delete(self._table).where(columns.token_hash.in_(oldest)))

    async def _revoke(self, condition: ColumnElement[bool], at_s: float) -> int:
        done = await self._connection.execute(
            update(self._table)
            .where(condition, self._table.c.revoked_at_s.is_(None))
            .values(revoked_at_s=at_s)
        )
        return done.rowcount
