"""Acknowledgements in SQL: who has taken on which alert, as long as its cause lasts.

The alerts themselves are made anew of how things are; only what a person has said must outlive a restart.
"""

from __future__ import annotations

from collections.abc import Collection

import msgspec
from sqlalchemy import delete, insert, select
from sqlalchemy.ext.asyncio import AsyncConnection

from dray.store.tables import acknowledgements


class Acknowledgement(msgspec.Struct, frozen=True, gc=False):
    """Somebody's word for an alert. Times are wall clock seconds."""

    alert: str
    since_at_s: float
    """When the alert began: the same alert may come again another day."""
    by: str
    """The name of the person."""
    at_s: float


class Acknowledgements:
    """The acknowledgements, inside one transaction."""

    def __init__(self, connection: AsyncConnection) -> None:
        self._connection = connection

    async def all(self) -> list[Acknowledgement]:
        """All of alerts that had not ended when the gateway last looked."""
        columns = [acknowledgements.c[name] for name in Acknowledgement.__struct_fields__]
        rows = await self._connection.execute(select(*columns))
        return [Acknowledgement(*row) for row in rows]

    async def put(self, acknowledgement: Acknowledgement) -> None:
        """Keep one, in place of an older one of the same alert."""
        await self.drop([acknowledgement.alert])
        await self._connection.execute(insert(acknowledgements), [msgspec.structs.asdict(acknowledgement)])

    async def drop(self, alerts: Collection[str]) -> None:
        """Forget those of alerts that have ended."""
        await self._connection.execute(delete(acknowledgements).where(acknowledgements.c.alert.in_(alerts)))
