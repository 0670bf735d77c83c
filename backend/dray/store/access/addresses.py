"""Addresses of gateways in SQL: where each was reached when it was started last, for links that commands print."""

from __future__ import annotations

from sqlalchemy import Column, Double, Table, Text, delete, insert, select
from sqlalchemy.ext.asyncio import AsyncConnection

from dray.store.tables import Id, metadata

addresses = Table(
    "addresses",
    metadata,
    Column("gateway", Id, primary_key=True),
    Column("url", Text, nullable=False),
    Column("at_s", Double, nullable=False),
    comment="Where each gateway was reached when it was started last. at_s: when that was, on its wall clock.",
)


class Addresses:
    """The addresses, inside one transaction."""

    def __init__(self, connection: AsyncConnection) -> None:
        self._connection = connection

    async def put(self, gateway: str, url: str, at_s: float) -> None:
        """Note the address of a gateway that is being started."""
        await self._connection.execute(delete(addresses).where(addresses.c.gateway == gateway))
        await self._connection.execute(insert(addresses), [{"gateway": gateway, "url": url, "at_s": at_s}])

    async def newest(self) -> str | None:
        """The address of the gateway that was started last; None before any."""
        query = select(addresses.c.url).order_by(addresses.c.at_s.desc()).limit(1)
        return (await self._connection.execute(query)).scalar()
