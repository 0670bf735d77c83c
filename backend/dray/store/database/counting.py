"""How many rows a list has, as far as that is cheap."""

from __future__ import annotations

from typing import Any

from sqlalchemy import Select, func, select
from sqlalchemy.ext.asyncio import AsyncConnection

TOTAL_MOST = 10_000
"""Rows that are counted: some milliseconds. Beyond, nobody needs the number to the last one."""


async def total_of(connection: AsyncConnection, query: Select[Any], most: int = TOTAL_MOST) -> int | None:
    """How many rows a query finds; None for more than `most`."""
    found = select(func.count()).select_from(query.limit(most + 1).subquery())
    count: int = (await connection.execute(found)).scalar_one()
    return count if count <= most else None
