"""Signing keys in SQL: the gateway signs grants of people's commands with them.

Any reader of this table can command every vehicle that trusts the key: protect the database.
"""

from __future__ import annotations

from sqlalchemy import select
from sqlalchemy.ext.asyncio import AsyncConnection

from dray.store.database.dialect import insert_new
from dray.store.tables import signing_keys


class SigningKeys:
    """The keys, inside one transaction."""

    def __init__(self, connection: AsyncConnection) -> None:
        self._connection = connection

    async def get(self, name: str, *, private: bytes, public: bytes, now_s: float) -> bytes:
        """The private key of this name; the given one is stored when there was none. Needs a write."""
        row = {
            "id": name,
            "private_key": private.hex(),
            "public_key": public.hex(),
            "created_at_s": now_s,
            "retired_at_s": None,
        }
        await self._connection.execute(insert_new(self._connection, signing_keys), [row])
        query = select(signing_keys.c.private_key).where(signing_keys.c.id == name)
        return bytes.fromhex((await self._connection.execute(query)).scalar_one())

    async def public(self, name: str) -> str | None:
        """The public key of this name, in hex; None when there is none."""
        query = select(signing_keys.c.public_key).where(signing_keys.c.id == name)
        found: str | None = (await self._connection.execute(query)).scalar_one_or_none()
        return found
