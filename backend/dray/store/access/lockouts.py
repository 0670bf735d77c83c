"""Lock-outs in SQL: consecutive failed logins by name, and the end of the pause that follows.

They are stored by the hash of the given name, whether it exists or not. So a lock-out does not reveal existing names, and a
password typed into the wrong field is not stored.
"""

from __future__ import annotations

import msgspec
from sqlalchemy import delete, func, insert, select
from sqlalchemy.ext.asyncio import AsyncConnection

from dray.store.access.digest import digest
from dray.store.tables import lockouts


class Lockout(msgspec.Struct, frozen=True):
    """Consecutive failed logins. Times are wall clock seconds."""

    failures: int
    failed_at_s: float
    until_s: float
    """Logins before this time are refused."""


class Lockouts:
    """The lock-outs, inside one transaction."""

    def __init__(self, connection: AsyncConnection) -> None:
        self._connection = connection

    async def get(self, name: str) -> Lockout | None:
        """The failures under this name; None when there are none."""
        columns = [lockouts.c[field] for field in Lockout.__struct_fields__]
        query = select(*columns).where(lockouts.c.subject == digest(name))
        row = (await self._connection.execute(query)).one_or_none()
        return None if row is None else Lockout(**row._mapping)  # noqa: SLF001 - SQLAlchemy's public name

    async def put(self, name: str, lockout: Lockout) -> None:
        """Store this one, replacing any earlier."""
        await self.clear(name)
        row = msgspec.structs.asdict(lockout)
        await self._connection.execute(insert(lockouts), [{"subject": digest(name), **row}])

    async def clear(self, name: str) -> None:
        """Delete the failures under this name."""
        await self._connection.execute(delete(lockouts).where(lockouts.c.subject == digest(name)))

    async def forget_before(self, at_s: float) -> None:
        """Delete those whose last failure was before this."""
        await self._connection.execute(delete(lockouts).where(lockouts.c.failed_at_s < at_s))

    async def count(self) -> int:
        """The number of names."""
        query = select(func.count()).select_from(lockouts)
        return (await self._connection.execute(query)).scalar_one()
