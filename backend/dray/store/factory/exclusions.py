"""Exclusions of agents in SQL, with reason and number of decision.

Decisions are numbered, and agents believe the list with the highest number. So a row stays after its agent's readmission: the
number of that decision must not be lost. A number is the time of its decision. So after the restoration of an old copy of the
database, new decisions still outrank all earlier ones.
"""

from __future__ import annotations

import msgspec
from sqlalchemy import delete, func, insert, select, update
from sqlalchemy.ext.asyncio import AsyncConnection

from dray.store.tables import exclusions


class Exclusion(msgspec.Struct, frozen=True, gc=False):
    """An excluded agent. Times are wall clock seconds."""

    agent: str
    reason: str
    by: str
    """The name of the person who decided it."""
    at_s: float


COLUMNS = [exclusions.c[name] for name in Exclusion.__struct_fields__]


class Exclusions:
    """The exclusions, inside one transaction."""

    def __init__(self, connection: AsyncConnection) -> None:
        self._connection = connection

    async def all(self) -> list[Exclusion]:
        """All present exclusions, by id of the agent."""
        query = select(*COLUMNS).where(exclusions.c.readmitted_at_s.is_(None)).order_by(exclusions.c.agent)
        return [Exclusion(*row) for row in await self._connection.execute(query)]

    async def number(self) -> int:
        """The number of the last decision; 0 for none."""
        return (await self._connection.execute(select(func.max(exclusions.c.number)))).scalar() or 0

    async def get(self, agent: str) -> Exclusion | None:
        """An agent's exclusion, or None."""
        query = select(*COLUMNS).where(exclusions.c.agent == agent, exclusions.c.readmitted_at_s.is_(None))
        row = (await self._connection.execute(query)).one_or_none()
        return None if row is None else Exclusion(*row)

    async def put(self, exclusion: Exclusion) -> None:
        """Exclude an agent that is not excluded."""
        number = await self._next(exclusion.at_s)
        await self._connection.execute(delete(exclusions).where(exclusions.c.agent == exclusion.agent))
        row = msgspec.structs.asdict(exclusion) | {"number": number, "readmitted_at_s": None}
        await self._connection.execute(insert(exclusions), [row])

    async def end(self, agent: str, at_s: float) -> None:
        """Readmit an excluded agent."""
        await self._connection.execute(
            update(exclusions)
            .where(exclusions.c.agent == agent)
            .values(number=await self._next(at_s), readmitted_at_s=at_s)
        )

    async def _next(self, at_s: float) -> int:
        return max(await self.number() + 1, int(at_s * 1000))
