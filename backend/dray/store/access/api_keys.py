"""API keys of other systems, in SQL. A key is looked up by the SHA-256 of its token."""

from __future__ import annotations

import msgspec
from sqlalchemy import ColumnElement, insert, select, update
from sqlalchemy.ext.asyncio import AsyncConnection

from dray.priorities import Priority
from dray.store.access.digest import digest
from dray.store.tables import api_keys

OPEN_MAX = 50
"""Default maximum of a key's open transports: a cell of some machines needs so many at once."""

OPEN_EACH_MAX = 20
"""The same at one place: more loads than any place has room for."""


class ApiKey(msgspec.Struct, frozen=True, kw_only=True):
    """A key of another system. Times are wall clock seconds."""

    id: str
    name: str
    scopes: str
    """The names of its scopes, separated by spaces."""
    created_at_s: float
    expires_at_s: float | None = None
    revoked_at_s: float | None = None
    used_at_s: float | None = None
    places: str = ""
    """The machines and storages to or from which it may call transports, separated by spaces; empty for all."""
    items: str = ""
    """The materials that it may have brought, separated by spaces; empty for all."""
    open_max: int = OPEN_MAX
    """Maximum open transports of it."""
    open_each_max: int = OPEN_EACH_MAX
    """Maximum open transports of it at one place."""
    priority: str = Priority.NORMAL.value
    """The highest priority that it may ask for."""


_NAMES = ApiKey.__struct_fields__

_COLUMNS = [api_keys.c[name] for name in _NAMES]


class ApiKeys:
    """The keys, inside one transaction."""

    def __init__(self, connection: AsyncConnection) -> None:
        self._connection = connection

    async def add(self, token: str, key: ApiKey) -> None:
        """Store a new key."""
        row = msgspec.structs.asdict(key)
        await self._connection.execute(insert(api_keys), [{"token_hash": digest(token), **row}])

    async def find(self, token: str) -> ApiKey | None:
        """The key with this token, usable or not."""
        return await self._one(api_keys.c.token_hash == digest(token))

    async def get(self, key_id: str) -> ApiKey | None:
        """The key with this id, usable or not."""
        return await self._one(api_keys.c.id == key_id)

    async def hold(self, key_id: str) -> None:
        """Lock this key until the transaction ends, so that counts of its rows stay valid."""
        await self._connection.execute(select(api_keys.c.id).where(api_keys.c.id == key_id).with_for_update())

    async def all(self) -> list[ApiKey]:
        """All keys, oldest first."""
        rows = await self._connection.execute(
            select(*_COLUMNS).order_by(api_keys.c.created_at_s, api_keys.c.id)
        )
        return [ApiKey(**row._mapping) for row in rows]  # noqa: SLF001 - SQLAlchemy's public name

    async def standing(self, most: int) -> list[tuple[str, ApiKey]]:
        """The keys that are not revoked, with the digests of their tokens; the newest first."""
        query = (
            select(api_keys.c.token_hash, *_COLUMNS)
            .where(api_keys.c.revoked_at_s.is_(None))
            .order_by(api_keys.c.created_at_s.desc(), api_keys.c.id)
            .limit(most)
        )
        rows = (await self._connection.execute(query)).mappings()
        return [(row["token_hash"], ApiKey(**{name: row[name] for name in _NAMES})) for row in rows]

    async def use(self, key_id: str, at_s: float) -> None:
        """Note the time of its use."""
        await self._connection.execute(update(api_keys).where(api_keys.c.id == key_id).values(used_at_s=at_s))

    async def revoke(self, key_id: str, at_s: float) -> int:
        """Revoke it; returns the number of keys revoked by this: 0 or 1."""
        done = await self._connection.execute(
            update(api_keys)
            .where(api_keys.c.id == key_id, api_keys.c.revoked_at_s.is_(None))
            .values(revoked_at_s=at_s)
        )
        return done.rowcount

    async def _one(self, condition: ColumnElement[bool]) -> ApiKey | None:
        row = (await self._connection.execute(select(*_COLUMNS).where(condition))).one_or_none()
        return None if row is None else ApiKey(**row._mapping)  # noqa: SLF001 - SQLAlchemy's public name
