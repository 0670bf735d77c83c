"""Secrets in SQL: random values, each created once for a database, as the salt of badge codes."""

from __future__ import annotations

import secrets as random

from sqlalchemy import select
from sqlalchemy.ext.asyncio import AsyncConnection

from dray.store.database.dialect import insert_new
from dray.store.tables import secrets

SIZE_BYTES = 32
"""The length of the hashes made with them."""


class Secrets:
    """The secrets, inside one transaction."""

    def __init__(self, connection: AsyncConnection) -> None:
        self._connection = connection

    async def get(self, name: str) -> str:
        """The secret of this name, in hexadecimal digits; created when missing. Needs a write."""
        row = {"name": name, "value": random.token_hex(SIZE_BYTES)}
        await self._connection.execute(insert_new(self._connection, secrets), [row])
        query = select(secrets.c.value).where(secrets.c.name == name)
        value: str = (await self._connection.execute(query)).scalar_one()
        return value
