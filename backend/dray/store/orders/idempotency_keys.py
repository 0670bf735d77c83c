"""Idempotency keys in SQL: the answers to requests that may be repeated.

The key is written in the order's own transaction, so neither exists without the other, even if the process dies.
"""

from __future__ import annotations

from collections.abc import Sequence

import msgspec
from sqlalchemy import Connection, delete, insert, select
from sqlalchemy.ext.asyncio import AsyncConnection

from dray.store.tables import idempotency_keys


class KeptAnswer(msgspec.Struct, frozen=True, gc=False):
    """The answer under a key."""

    key: str
    fingerprint: str
    """A digest of the request, to distinguish requests."""
    order_id: str
    answer: str
    """The body of the answer."""
    at_s: float
    """Wall clock."""


_KNOWN = f"SELECT {', '.join(KeptAnswer.__struct_fields__)} FROM idempotency_keys WHERE key"  # noqa: S608 - ours

_KNOWN_TO_POSTGRESQL = f"{_KNOWN} = ANY($1)"

_KNOWN_TO_SQLITE = f"{_KNOWN} IN (SELECT value FROM json_each(?))"  # noqa: S608 - likewise


def known_answers(connection: Connection, keys: Sequence[str]) -> dict[str, KeptAnswer]:
    """The answers under some keys, by key. Every order needs this, so it calls the driver directly."""
    if not keys:
        return {}
    if connection.dialect.name == "postgresql":
        rows = connection.exec_driver_sql(_KNOWN_TO_POSTGRESQL, (keys,))
    else:
        rows = connection.exec_driver_sql(_KNOWN_TO_SQLITE, (msgspec.json.encode(keys).decode(),))
    return {row.key: KeptAnswer(*row) for row in rows}


class IdempotencyKeys:
    """The keys, inside one transaction."""

    def __init__(self, connection: AsyncConnection) -> None:
        self._connection = connection

    async def get(self, key: str) -> KeptAnswer | None:
        """The answer under this key, or None."""
        query = select(idempotency_keys).where(idempotency_keys.c.key == key)
        row = (await self._connection.execute(query)).one_or_none()
        return None if row is None else KeptAnswer(**row._mapping)  # noqa: SLF001 - SQLAlchemy's public name

    async def add(self, answer: KeptAnswer) -> None:
        """Store an answer."""
        await self._connection.execute(insert(idempotency_keys), [msgspec.structs.asdict(answer)])

    async def forget_before(self, at_s: float) -> None:
        """Delete older answers."""
        await self._connection.execute(delete(idempotency_keys).where(idempotency_keys.c.at_s < at_s))
