"""The ages of consecutively stored rows, even if a clock was ahead for some of them.

Rows are deleted in their order of storage, up to the first that must stay. A row with a future time is older than the next row with
a past time, and counts as that old. So a clock that was a year ahead for an hour does not keep all later rows for a year.
"""

from __future__ import annotations

from sqlalchemy import Table, select
from sqlalchemy.ext.asyncio import AsyncConnection


async def oldest(connection: AsyncConnection, of: Table, limit: int, now_s: float) -> list[tuple[int, float]]:
    """The first rows of a table with `position` and `at_s`, each with its latest possible time (wall clock).

    Args:
        connection: a transaction.
        of: the table.
        limit: maximum number of rows.
        now_s: the wall clock.
    """
    c = of.c
    query = select(c.position, c.at_s).order_by(c.position).limit(limit)
    rows = [(row.position, row.at_s) for row in await connection.execute(query)]
    latest_s = now_s
    if rows and rows[-1][1] > now_s:
        come = select(c.at_s).where(c.position > rows[-1][0], c.at_s <= now_s)
        latest_s = await connection.scalar(come.order_by(c.position).limit(1)) or now_s
    known: list[tuple[int, float]] = []
    for position, at_s in reversed(rows):
        if at_s <= now_s:
            latest_s = at_s
        known.append((position, latest_s))
    return known[::-1]
