"""The baseline: taking orders, and nothing else. FastAPI, SQLAlchemy, an INSERT for each table.

The same model as ours checks the body, the same rows go into the same tables with the same indexes, and an answered
order is on disk: SQLite writes through at every commit, and PostgreSQL's `synchronous_commit` is on.
"""

from __future__ import annotations

import time
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager
from typing import Annotated, Any

import msgspec
from fastapi import FastAPI, Header
from sqlalchemy import Table, event, insert
from sqlalchemy.ext.asyncio import create_async_engine

from dray.gateway.orders.drafts import OrderDraft
from dray.gateway.orders.order_ids import Ids, new_token
from dray.plant import default_plant
from dray.store.access.audit import AuditRow, row_of_line
from dray.store.access.digest import digest
from dray.store.orders.change_log import ORDER, change_log
from dray.store.orders.orders import Item, Order, rows_of_items, rows_of_orders
from dray.store.orders.progress import OrderStatus
from dray.store.tables import (
    audit,
    idempotency_keys,
    metadata,
    order_items,
    orders,
    products,
    tracking_links,
)

PRODUCTS = default_plant().file.products


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
            # Without our triggers: it writes the change log itself.
            await connection.run_sync(metadata.create_all)
            known = [{"id": each.id, "name": each.name, "made_here": True} for each in PRODUCTS]
            await connection.execute(insert(products), known)
        yield
        await engine.dispose()

    app, ids = FastAPI(lifespan=lifespan), Ids("O")

    @app.post("/api/orders", status_code=201)
    async def place(draft: OrderDraft, idempotency_key: Annotated[str, Header()]) -> dict[str, Any]:
        order = _order(ids.next(time.time()), draft)
        answer = msgspec.to_builtins(order)
        async with engine.begin() as connection:
            for table, rows in _rows(order, idempotency_key, msgspec.json.encode(answer).decode()):
                await connection.execute(insert(table), rows)
        return answer  # type: ignore[no-any-return]

    return app


def _order(name: str, draft: OrderDraft) -> Order:
    now_s = time.time()
    return Order(
        id=name,
        status=OrderStatus.RELEASED,
        customer=draft.customer,
        token=new_token(),
        items=tuple(Item(item.product, item.quantity) for item in draft.items),
        created_at_s=now_s,
        reference=draft.reference,
        released_at_s=now_s,
        releases=1,
        updated_at_s=now_s,
    )


def _rows(order: Order, key: str, answer: str) -> Iterator[tuple[Table, list[dict[str, object]]]]:
    """The rows that ours writes, too, when it takes an order."""
    at_s = order.created_at_s
    yield orders, rows_of_orders([order])
    yield order_items, rows_of_items([order])
    yield tracking_links, [{"token_hash": digest(order.token), "order_id": order.id, "created_at_s": at_s}]
    yield (
        idempotency_keys,
        [{"key": key, "fingerprint": digest(answer), "order_id": order.id, "answer": answer, "at_s": at_s}],
    )
    line = AuditRow(
        at_s=at_s, who="ERP", who_kind="key", action="order.place", target=order.id, result="done"
    )
    yield audit, [row_of_line(line)]
    yield change_log, [{"kind": ORDER, "subject": order.id, "status": order.status, "at_s": at_s}]


def _keep_on_disk(connection: Any, _record: Any) -> None:
    """Like ours: an answered order outlives a power failure."""
    cursor = connection.cursor()
    for pragma in ("busy_timeout = 60000", "journal_mode = WAL", "synchronous = FULL"):
        cursor.execute(f"PRAGMA {pragma}")
    cursor.close()
