"""The audit log in SQL: actions and attempts, with their authors and results. Rows are only ever added."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Any

import msgspec
from sqlalchemy import ColumnElement, Connection, delete, insert, or_, select
from sqlalchemy.ext.asyncio import AsyncConnection

from dray.store.database.counting import total_of
from dray.store.database.database import Database
from dray.store.database.searching import Sought
from dray.store.database.together import Together
from dray.store.tables import audit, orders


class AuditRow(msgspec.Struct, frozen=True, kw_only=True):
    """One line of the audit log."""

    position: int = 0
    """The line's number, which the database assigns in ascending order."""
    at_s: float
    """Wall clock."""
    who: str
    """The id of a person or key; for an unrecognised author the claimed one."""
    who_kind: str
    """person, key, admin, console or nobody."""
    from_ip: str = ""
    session: str = ""
    action: str
    """The action, as `vehicle.command`."""
    target: str = ""
    """The subject, as a vehicle's id."""
    result: str
    """done, refused (by a rule or the vehicle) or failed."""
    detail: dict[str, Any] | Annotated[msgspec.Raw, msgspec.Meta(extra_json_schema={"type": "object"})] = {}


LINE = [audit.c[name] for name in AuditRow.__struct_fields__]
"""The columns of a line."""


class AuditFilter(msgspec.Struct, frozen=True, kw_only=True):
    """A filter for lines; empty fields match all."""

    since_s: float | None = None
    until_s: float | None = None
    who: str = ""
    action: str = ""
    target: str = ""
    result: str = ""
    words: tuple[Sought, ...] = ()
    """Words that must all occur in a line: in author, action, subject, origin or detail."""
    by_orders: bool = False
    """Whether words are also searched in the texts of the line's order."""


class Audit:
    """The audit log, inside one transaction."""

    def __init__(self, connection: AsyncConnection) -> None:
        self._connection = connection

    async def add(self, row: AuditRow) -> int:
        """Add a line; returns its position."""
        done = await self._connection.execute(insert(audit).returning(audit.c.position), [row_of_line(row)])
        position: int = done.scalar_one()
        return position

    async def page(
        self, wanted: AuditFilter, after: int | None, limit: int, *, oldest_first: bool = False
    ) -> list[AuditRow]:
        """Lines, newest first.

        Args:
            wanted: the filter.
            after: only lines after this position, in the chosen direction.
            limit: maximum number of lines.
            oldest_first: the other direction.
        """
        position, conditions = audit.c.position, list(_conditions(wanted))
        if after is not None:
            conditions.append(position > after if oldest_first else position < after)
        query = select(*LINE).where(*conditions).limit(limit)
        query = query.order_by(position if oldest_first else position.desc())
        rows = [dict(row._mapping) for row in await self._connection.execute(query)]  # noqa: SLF001 - SQLAlchemy's public name
        return [AuditRow(**row | {"detail": msgspec.Raw(row["detail"].encode())}) for row in rows]

    async def total(self, wanted: AuditFilter) -> int | None:
        """The number of matching lines; None for very many."""
        return await total_of(self._connection, select(audit.c.position).where(*_conditions(wanted)))

    async def prune(self, before_s: float, at_most: int) -> int:
        """Delete some of the lines from before this moment; returns the number."""
        old = select(audit.c.position).where(audit.c.at_s < before_s).limit(at_most)
        return (await self._connection.execute(delete(audit).where(audit.c.position.in_(old)))).rowcount


class AuditLines:
    """Adds lines in transactions of their own. Lines that come while others are being written share the next one.

    Args:
        database: the database.
    """

    def __init__(self, database: Database) -> None:
        self._database = database
        self._together: Together[AuditRow, None] = Together(database, _added, lambda _lines: None)

    async def add(self, line: AuditRow) -> None:
        """Add a line; it is on disk when this returns. A cancelled caller does not undo it.

        Raises:
            UnavailableError: writing is impossible at present, or too many lines wait.
        """
        await self._together.do(line)

    async def add_all(self, lines: Sequence[AuditRow]) -> None:
        """Add lines, at least one, all or none; they are on disk when this returns.

        Raises:
            UnavailableError: writing is impossible at present.
        """
        await self._database.do(lambda connection: _added(connection, lines))


def _added(connection: Connection, lines: Sequence[AuditRow]) -> Sequence[None]:
    connection.execute(insert(audit), [row_of_line(line) for line in lines])
    return [None] * len(lines)


def row_of_line(line: AuditRow) -> dict[str, object]:
    """A new line as a row of the table."""
    fields = msgspec.structs.asdict(line)
    del fields["position"]
    detail = msgspec.json.encode(line.detail).decode()
    search = "\n".join((line.who, line.action, line.target, line.from_ip, detail)).casefold()
    return fields | {"detail": detail, "search": search}


def _conditions(wanted: AuditFilter) -> list[ColumnElement[bool]]:
    conditions: list[ColumnElement[bool]] = [
        audit.c[name] == value
        for name in ("who", "action", "target", "result")
        if (value := getattr(wanted, name))
    ]
    if wanted.since_s is not None:
        conditions.append(audit.c.at_s >= wanted.since_s)
    if wanted.until_s is not None:
        conditions.append(audit.c.at_s < wanted.until_s)
    conditions += [_holds(word, by_orders=wanted.by_orders) for word in wanted.words]
    return conditions


def _holds(word: Sought, *, by_orders: bool) -> ColumnElement[bool]:
    # No word contains a line break, so none matches across two texts.
    texts = (word.text, *(f'"{item}"' for item in word.named))
    found = [audit.c.search.contains(text.casefold(), autoescape=True) for text in texts]
    if by_orders:
        named = select(orders.c.id).where(orders.c.search.contains(word.text.casefold(), autoescape=True))
        found.append(audit.c.target.in_(named))
    return or_(*found)
