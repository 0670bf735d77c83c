"""Login sessions in SQL. A session is looked up by the SHA-256 of its token."""

from __future__ import annotations

from collections.abc import Iterable

import msgspec
from sqlalchemy import ColumnElement, delete, insert, select, update
from sqlalchemy.ext.asyncio import AsyncConnection

from dray.store.access.digest import digest
from dray.store.tables import sessions


class Session(msgspec.Struct, frozen=True, kw_only=True):
    """One login. Times are wall clock seconds."""

    id: str
    """Its id in the audit log; no secret."""
    person_id: str
    station: str = ""
    created_at_s: float
    used_at_s: float
    expires_at_s: float
    ended_at_s: float | None = None
    """The time of the logout, revocation, or replacement; None for an expired session."""


_NAMES = Session.__struct_fields__

_COLUMNS = [sessions.c[name] for name in _NAMES]


class Sessions:
    """The sessions, inside one transaction."""

    def __init__(self, connection: AsyncConnection) -> None:
        self._connection = connection

    async def add(self, token: str, session: Session) -> None:
        """Store a new session."""
        row = msgspec.structs.asdict(session)
        await self._connection.execute(insert(sessions), [{"token_hash": digest(token), **row}])

    async def find(self, token: str) -> Session | None:
        """The session with this token, ended or not."""
        query = select(*_COLUMNS).where(sessions.c.token_hash == digest(token))
        row = (await self._connection.execute(query)).one_or_none()
        return None if row is None else Session(**row._mapping)  # noqa: SLF001 - SQLAlchemy's public name

    async def some(self, ids: Iterable[str]) -> list[Session]:
        """The sessions with these ids, if they exist."""
        query = select(*_COLUMNS).where(sessions.c.id.in_(list(ids)))
        rows = await self._connection.execute(query)
        return [Session(**row._mapping) for row in rows]  # noqa: SLF001 - SQLAlchemy's public name

    async def was_replaced(self, session: Session) -> bool:
        """Whether it ended because its person logged in again at that moment."""
        if session.ended_at_s is None:
            return False
        same = (sessions.c.person_id == session.person_id, sessions.c.created_at_s == session.ended_at_s)
        query = select(sessions.c.id).where(*same, sessions.c.id != session.id).limit(1)
        return (await self._connection.execute(query)).first() is not None

    async def latest(self, since_s: float, most: int) -> list[tuple[str, Session]]:
        """The sessions that had not ended before `since_s`, with the digests of their tokens; the last used first."""
        query = (
            select(sessions.c.token_hash, *_COLUMNS)
            .where(sessions.c.ended_at_s.is_(None) | (sessions.c.ended_at_s >= since_s))
            .order_by(sessions.c.used_at_s.desc(), sessions.c.id)
            .limit(most)
        )
        rows = (await self._connection.execute(query)).mappings()
        return [(row["token_hash"], Session(**{name: row[name] for name in _NAMES})) for row in rows]

    async def use(self, ids: Iterable[str], at_s: float) -> None:
        """Note the time of their use."""
        query = update(sessions).where(sessions.c.id.in_(list(ids))).values(used_at_s=at_s)
        await self._connection.execute(query)

    async def station(self, session_id: str, station: str) -> None:
        """Note the machine at which this session's person works."""
        query = update(sessions).where(sessions.c.id == session_id).values(station=station)
        await self._connection.execute(query)

    async def end(self, session_id: str, at_s: float) -> int:
        """End one; returns the number ended by this: 0 or 1."""
        return await self._end(sessions.c.id == session_id, at_s)

    async def end_all(self, person_id: str, at_s: float) -> int:
        """End all of a person; returns the number ended by this."""
        return await self._end(sessions.c.person_id == person_id, at_s)

    async def forget_before(self, at_s: float) -> None:
        """Delete those that expired before this."""
        await self._connection.execute(delete(sessions).where(sessions.c.expires_at_s < at_s))

    async def _end(self, condition: ColumnElement[bool], at_s: float) -> int:
        query = update(sessions).where(condition, sessions.c.ended_at_s.is_(None)).values(ended_at_s=at_s)
        return (await self._connection.execute(query)).rowcount
