"""How old rows are that are kept one after another, though a clock may have been ahead when some of them were.

Rows are forgotten in the order in which they came, up to the first that is to be kept. A row whose time has not come yet tells nothing by
it: it is older than the next row whose time has, and counts as that one. So a clock that was a year ahead for an hour does not keep
everything after it for a year.
"""

from __future__ import annotations

from sqlalchemy import Table, select
from sqlalchemy.ext.asyncio import AsyncConnection


async def oldest(connection: AsyncConnection, of: Table, limit: int, now_s: float) -> list[tuple[int, float]]:
    """The first rows of a table with `position` and `at_s`, and when each happened at the latest (wall clock).

    Args:
        connection: a transaction.
        of: the table.
        limit: how many at most.
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
