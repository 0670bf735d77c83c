"""The audit log: actions, attempts and results."""

from __future__ import annotations

from collections.abc import AsyncIterator, Mapping
from typing import Annotated, Literal

import msgspec
from fastapi import APIRouter, Query
from fastapi.responses import Response

from dray.gateway.access.access import Access
from dray.gateway.access.caller import Caller
from dray.gateway.access.principal import Scope
from dray.gateway.http.csv_tables import Format, Row, header_of, row_of, table, with_csv
from dray.gateway.http.provided import Provided
from dray.gateway.http.responses import (
    PAGE,
    Cursor,
    Json,
    Limit,
    counted,
    counted_list_of,
    read_cursor,
    write_cursor,
)
from dray.gateway.routes.search import Words
from dray.store import Store
from dray.store.access.audit import AuditFilter, AuditRow

router = APIRouter(tags=["access"])

COLUMNS = AuditRow.__struct_fields__

ROWS_AT_ONCE = 1_000
"""Lines per read for a table, so that a long log does not block the database."""

LAST_POSITION = 2**63 - 1
"""The largest integer in SQL."""

LAST_S = 1e12
"""Some 30,000 years."""


class AuditLine(AuditRow, frozen=True, kw_only=True):
    """A line of the audit log, with its order if it is about one."""

    is_order: bool = False
    """Whether `target` is an order that the caller may read."""
    reference: str | None = None
    """The customer's own number of that order."""


Moment = Annotated[float | None, Query(ge=0, le=LAST_S, description="Seconds since 1970")]
Word = Annotated[str, Query(max_length=128, pattern=r"^[^\x00]*$")]


@router.get(
    "/audit",
    responses={200: with_csv(counted_list_of(AuditLine, "Lines, newest first"))},
    response_class=Json,
)
async def list_audit(
    store: Provided[Store],
    access: Provided[Access],
    caller: Caller,
    words: Words,
    since: Moment = None,
    until: Moment = None,
    who: Word = "",
    action: Word = "",
    target: Word = "",
    result: Literal["", "done", "refused", "failed"] = "",
    oldest_first: bool = False,
    cursor: Cursor = None,
    limit: Limit = PAGE,
    format: Format = "json",  # noqa: A002 - the word that others use
) -> Response:
    """Actions and attempts of people and other systems.

    Words of `q` may occur in caller, action, target, address and detail, and in the reference of the order
    concerned. `since` and `until` bound the time; `who`, `action`, `target` and `result` must match exactly.
    """
    after = read_cursor(cursor, tuple[Annotated[int, msgspec.Meta(ge=0, le=LAST_POSITION)]])
    sees_orders = caller.may(Scope.ORDERS_READ)
    wanted = AuditFilter(
        since_s=since,
        until_s=until,
        who=who,
        action=action,
        target=target,
        result=result,
        words=words,
        by_orders=sees_orders,
    )
    # Lines of stops are written after their answers: write them before reading the log.
    await access.audit_log.catch_up()
    if format == "csv":
        return table("audit", header_of(COLUMNS), _rows(store, wanted, oldest_first))
    async with store.read() as work:
        place = None if after is None else after[0]
        rows = await work.audit.page(wanted, place, limit + 1, oldest_first=oldest_first)
        is_all = cursor is None and len(rows) <= limit
        total = len(rows) if is_all else None if words else await work.audit.total(wanted)
        targets = {row.target for row in rows[:limit] if row.target} if sees_orders else set()
        orders = await work.orders.names(targets)
    next_cursor = write_cursor(rows[limit - 1].position) if len(rows) > limit else None
    return counted([_line(row, orders) for row in rows[:limit]], next_cursor, total)


def _line(row: AuditRow, orders: Mapping[str, str | None]) -> AuditLine:
    told = {name: getattr(row, name) for name in AuditRow.__struct_fields__}
    return AuditLine(**told, is_order=row.target in orders, reference=orders.get(row.target))


async def _rows(store: Store, wanted: AuditFilter, oldest_first: bool) -> AsyncIterator[Row]:
    """All matching lines as table cells."""
    after = None
    while True:
        async with store.read() as work:
            rows = await work.audit.page(wanted, after, ROWS_AT_ONCE, oldest_first=oldest_first)
        for row in rows:
            detail = msgspec.json.encode(row.detail).decode()
            yield [*row_of(COLUMNS[:-1], row), detail]
        if len(rows) < ROWS_AT_ONCE:
            return
        after = rows[-1].position
