"""Closures in SQL: people's closures for vehicles, with reason, end, and number of decision.

Decisions are numbered like those about exclusions (`dray.store.factory.exclusions`). A row stays after its closure's end, so that
the number of that decision is not lost.
"""

from __future__ import annotations

import msgspec
from sqlalchemy import delete, func, insert, select, update
from sqlalchemy.ext.asyncio import AsyncConnection

from dray.store.tables import closures

KEPT_S = 30 * 86400.0
"""Seconds after its end at which a closure is deleted; the audit log keeps it longer."""


class ClosureRow(msgspec.Struct, frozen=True, gc=False):
    """One closure. Times are wall clock seconds; exactly one of lane, place, area and outline is set."""

    id: str
    kind: str
    """closed, slow or one_way."""
    start_node: str
    end_node: str
    place: str
    area: str
    outline: str
    """The corners, as a JSON array of pairs (m); empty for none."""
    speed_mps: float | None
    until_s: float | None
    """The automatic end; None for an end by a person."""
    reason: str
    by: str
    """The name of the person who decided it."""
    person: str
    """The person's name, as vehicles are told it."""
    at_s: float
    number: int = 0
    """The number of the decision; assigned when it is stored."""

    @property
    def subject(self) -> tuple[str | float | None, ...]:
        """The closed thing, and the kind of closure."""
        return self.kind, self.start_node, self.end_node, self.place, self.area, self.outline, self.speed_mps


COLUMNS = [closures.c[name] for name in ClosureRow.__struct_fields__]


class Closures:
    """The closures, inside one transaction."""

    def __init__(self, connection: AsyncConnection) -> None:
        self._connection = connection

    async def all(self) -> list[ClosureRow]:
        """The closures that nobody has ended and that have not expired, the oldest first."""
        query = (
            select(*COLUMNS).where(closures.c.ended_at_s.is_(None)).order_by(closures.c.at_s, closures.c.id)
        )
        return [ClosureRow(*row) for row in await self._connection.execute(query)]

    async def number(self) -> int:
        """The number of the last decision; 0 for none."""
        return (await self._connection.execute(select(func.max(closures.c.number)))).scalar() or 0

    async def get(self, closure: str) -> ClosureRow | None:
        """A closure in force, or None."""
        query = select(*COLUMNS).where(closures.c.id == closure, closures.c.ended_at_s.is_(None))
        row = (await self._connection.execute(query)).one_or_none()
        return None if row is None else ClosureRow(*row)

    async def put(self, closure: ClosureRow) -> None:
        """Store a closure, and delete those that ended long ago."""
        number = await self._next(closure.at_s)
        row = msgspec.structs.asdict(closure) | {"number": number, "ended_at_s": None}
        await self._connection.execute(insert(closures), [row])
        await self._connection.execute(delete(closures).where(closures.c.ended_at_s < closure.at_s - KEPT_S))

    async def end(self, closure: str, at_s: float) -> None:
        """End a closure."""
        await self._connection.execute(
            update(closures)
            .where(closures.c.id == closure, closures.c.ended_at_s.is_(None))
            .values(number=await self._next(at_s), ended_at_s=at_s)
        )

    async def _next(self, at_s: float) -> int:
        return max(await self.number() + 1, int(at_s * 1000))
