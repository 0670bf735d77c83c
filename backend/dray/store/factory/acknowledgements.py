"""Acknowledgements in SQL: who has taken on which alert, as long as its cause lasts.

The alerts themselves are made anew of how things are; only what a person has said must outlive a restart.
"""

from __future__ import annotations

from collections.abc import Mapping

import msgspec
from sqlalchemy import bindparam, delete, insert, select
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


COLUMNS = [acknowledgements.c[name] for name in Acknowledgement.__struct_fields__]


class Acknowledgements:
    """The acknowledgements, inside one transaction."""

    def __init__(self, connection: AsyncConnection) -> None:
        self._connection = connection

    async def all(self) -> list[Acknowledgement]:
        """All of alerts that had not ended when a gateway last looked."""
        return [Acknowledgement(*row) for row in await self._connection.execute(select(*COLUMNS))]

    async def get(self, alert: str) -> Acknowledgement | None:
        """That of one alert, or None."""
        query = select(*COLUMNS).where(acknowledgements.c.alert == alert)
        row = (await self._connection.execute(query)).one_or_none()
        return None if row is None else Acknowledgement(*row)

    async def put(self, acknowledgement: Acknowledgement) -> None:
        """Keep one, in place of an older one of the same alert."""
        await self._connection.execute(
            delete(acknowledgements).where(acknowledgements.c.alert == acknowledgement.alert)
        )
        await self._connection.execute(insert(acknowledgements), [msgspec.structs.asdict(acknowledgement)])

    async def drop(self, ended: Mapping[str, float]) -> None:
        """Forget those of alerts that have ended.

        Args:
            ended: by alert, when that was seen. It may have come again since, and somebody have taken it on.
        """
        await self._connection.execute(
            delete(acknowledgements).where(
                acknowledgements.c.alert == bindparam("ended"),
                acknowledgements.c.at_s <= bindparam("seen_at_s"),
            ),
            [{"ended": alert, "seen_at_s": at_s} for alert, at_s in ended.items()],
        )
