"""Lock-outs in SQL: how often a login under a name has failed in a row, and until when none is tried.

They are kept by the name that was given, whether anybody has it or not, and only its hash: so a lock-out
tells nobody which names there are, and a password that was typed into the wrong field is not written down.
"""

from __future__ import annotations

import msgspec
from sqlalchemy import delete, func, insert, select
from sqlalchemy.ext.asyncio import AsyncConnection

from dray.store.access.digest import digest
from dray.store.tables import lockouts


class Lockout(msgspec.Struct, frozen=True):
    """Failed logins in a row. Times are wall clock seconds."""

    failures: int
    failed_at_s: float
    until_s: float
    """Nothing is tried before."""


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
        """Keep this one instead of what there was."""
        await self.clear(name)
        row = msgspec.structs.asdict(lockout)
        await self._connection.execute(insert(lockouts), [{"subject": digest(name), **row}])

    async def clear(self, name: str) -> None:
        """Forget the failures under this name."""
        await self._connection.execute(delete(lockouts).where(lockouts.c.subject == digest(name)))

    async def forget_before(self, at_s: float) -> None:
        """Forget those whose last failure was before this."""
        await self._connection.execute(delete(lockouts).where(lockouts.c.failed_at_s < at_s))

    async def count(self) -> int:
        """How many names there are."""
        query = select(func.count()).select_from(lockouts)
        return (await self._connection.execute(query)).scalar_one()
