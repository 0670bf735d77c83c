"""The number of rows in a list, as far as counting is cheap."""

from __future__ import annotations

from typing import Any

from sqlalchemy import Select, func, select
from sqlalchemy.ext.asyncio import AsyncConnection

TOTAL_MOST = 10_000
"""Maximum rows counted, in some milliseconds. Beyond that the exact number does not matter."""


async def total_of(connection: AsyncConnection, query: Select[Any], most: int = TOTAL_MOST) -> int | None:
    """The number of rows of a query; None for more than `most`."""
    found = select(func.count()).select_from(query.limit(most + 1).subquery())
    count: int = (await connection.execute(found)).scalar_one()
    return count if count <= most else None
