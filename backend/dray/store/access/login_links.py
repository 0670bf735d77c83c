"""Login links in SQL: each logs one person in, once."""

from __future__ import annotations

import msgspec
from sqlalchemy import delete, insert, select, update
from sqlalchemy.ext.asyncio import AsyncConnection

from dray.store.access.digest import digest
from dray.store.tables import login_links


class LoginLink(msgspec.Struct, frozen=True):
    """A link that logs a person in once. Times are wall clock seconds."""

    person_id: str
    created_at_s: float
    expires_at_s: float
    ended_at_s: float | None = None
    """The time of its use or revocation."""


class LoginLinks:
    """The links, inside one transaction."""

    def __init__(self, connection: AsyncConnection) -> None:
        self._connection = connection

    async def add(self, token: str, link: LoginLink) -> None:
        """Store a new link."""
        row = msgspec.structs.asdict(link)
        await self._connection.execute(insert(login_links), [{"token_hash": digest(token), **row}])

    async def find(self, token: str) -> LoginLink | None:
        """The link with this token, ended or not."""
        columns = [login_links.c[name] for name in LoginLink.__struct_fields__]
        query = select(*columns).where(login_links.c.token_hash == digest(token))
        row = (await self._connection.execute(query)).one_or_none()
        return None if row is None else LoginLink(**row._mapping)  # noqa: SLF001 - SQLAlchemy's public name

    async def use(self, token: str, at_s: float) -> bool:
        """Use the link up; False when it was used, revoked or expired. Only one of two concurrent calls is True."""
        done = await self._connection.execute(
            update(login_links)
            .where(
                login_links.c.token_hash == digest(token),
                login_links.c.ended_at_s.is_(None),
                login_links.c.expires_at_s > at_s,
            )
            .values(ended_at_s=at_s)
        )
        return done.rowcount == 1

    async def end_all(self, person_id: str, at_s: float) -> None:
        """Revoke all links of a person."""
        await self._connection.execute(
            update(login_links)
            .where(login_links.c.person_id == person_id, login_links.c.ended_at_s.is_(None))
            .values(ended_at_s=at_s)
        )

    async def forget_before(self, at_s: float) -> None:
        """Delete those that expired before this."""
        await self._connection.execute(delete(login_links).where(login_links.c.expires_at_s < at_s))
