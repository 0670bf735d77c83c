"""Exclusions in SQL: which agents people have shut out, why, and by which decision.

Decisions are numbered, and agents believe the list with the highest number. So a row stays when its agent is
readmitted: the number of that decision must not be lost. A number is the time of its decision; so decisions
after the restoring of an old copy of the database count more than those that were made before.
"""

from __future__ import annotations

import msgspec
from sqlalchemy import delete, func, insert, select, update
from sqlalchemy.ext.asyncio import AsyncConnection

from dray.store.tables import exclusions


class Exclusion(msgspec.Struct, frozen=True, gc=False):
    """An agent that nobody hears any more. Times are wall clock seconds."""

    agent: str
    reason: str
    by: str
    """The name of who has decided it."""
    at_s: float


COLUMNS = [exclusions.c[name] for name in Exclusion.__struct_fields__]


class Exclusions:
    """The exclusions, inside one transaction."""

    def __init__(self, connection: AsyncConnection) -> None:
        self._connection = connection

    async def all(self) -> list[Exclusion]:
        """All agents that are shut out at present, by id."""
        query = select(*COLUMNS).where(exclusions.c.readmitted_at_s.is_(None)).order_by(exclusions.c.agent)
        return [Exclusion(*row) for row in await self._connection.execute(query)]

    async def number(self) -> int:
        """The number of the last decision; 0 when there was none."""
        return (await self._connection.execute(select(func.max(exclusions.c.number)))).scalar() or 0

    async def get(self, agent: str) -> Exclusion | None:
        """That of one agent, or None when it is not shut out."""
        query = select(*COLUMNS).where(exclusions.c.agent == agent, exclusions.c.readmitted_at_s.is_(None))
        row = (await self._connection.execute(query)).one_or_none()
        return None if row is None else Exclusion(*row)

    async def put(self, exclusion: Exclusion) -> None:
        """Shut an agent out that is not."""
        number = await self._next(exclusion.at_s)
        await self._connection.execute(delete(exclusions).where(exclusions.c.agent == exclusion.agent))
        row = msgspec.structs.asdict(exclusion) | {"number": number, "readmitted_at_s": None}
        await self._connection.execute(insert(exclusions), [row])

    async def end(self, agent: str, at_s: float) -> None:
        """Readmit an agent that is shut out."""
        await self._connection.execute(
            update(exclusions)
            .where(exclusions.c.agent == agent)
            .values(number=await self._next(at_s), readmitted_at_s=at_s)
        )

    async def _next(self, at_s: float) -> int:
        return max(await self.number() + 1, int(at_s * 1000))
