"""The baseline: orders as they are taken by whoever needs nothing else. FastAPI, SQLAlchemy, one INSERT.

The body is looked at by the same model as ours, and an answered order is on disk: SQLite writes through at every commit,
and PostgreSQL's `synchronous_commit` is on.
"""

from __future__ import annotations

import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any
from uuid import uuid4

from fastapi import FastAPI
from sqlalchemy import JSON, Boolean, Column, Double, MetaData, String, Table, event, insert
from sqlalchemy.ext.asyncio import create_async_engine

from dray.gateway.orders.drafts import OrderDraft

METADATA = MetaData()

ORDERS = Table(
    "orders",
    METADATA,
    Column("id", String(36), primary_key=True),
    Column("customer", String(200), nullable=False),
    Column("reference", String(200)),
    Column("items", JSON, nullable=False),
    Column("due_at_s", Double),
    Column("release", Boolean, nullable=False),
    Column("created_at_s", Double, nullable=False),
)


def create_bare_app(url: str) -> FastAPI:
    """An application with one call.

    Args:
        url: of an empty database.
    """
    engine = create_async_engine(url)
    if url.startswith("sqlite"):
        event.listen(engine.sync_engine, "connect", _keep_on_disk)

    @asynccontextmanager
    async def lifespan(_app: FastAPI) -> AsyncIterator[None]:
        async with engine.begin() as connection:
            await connection.run_sync(METADATA.create_all)
        yield
        await engine.dispose()

    app = FastAPI(lifespan=lifespan)

    @app.post("/api/orders", status_code=201)
    async def place(draft: OrderDraft) -> dict[str, Any]:
        row = draft.model_dump(exclude={"due_at"})
        due_at_s = None if draft.due_at is None else draft.due_at.timestamp()
        row |= {"id": str(uuid4()), "created_at_s": time.time(), "due_at_s": due_at_s}
        async with engine.begin() as connection:
            await connection.execute(insert(ORDERS), row)
        return row

    return app


def _keep_on_disk(connection: Any, _record: Any) -> None:
    """As ours does it: an answered order outlives a power failure."""
    cursor = connection.cursor()
    for pragma in ("busy_timeout = 60000", "journal_mode = WAL", "synchronous = FULL"):
        cursor.execute(f"PRAGMA {pragma}")
    cursor.close()
