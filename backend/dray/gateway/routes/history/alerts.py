"""All past and present alerts: begin, end, acknowledgements and comments."""

from __future__ import annotations

from collections.abc import AsyncIterator
from typing import Annotated, Literal

import msgspec
from fastapi import APIRouter, Query
from fastapi.responses import Response

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
    iso,
    read_cursor,
    write_cursor,
)
from dray.gateway.live.views import AlertKind, AlertRecord, AlertView, AlertWordView
from dray.gateway.orders.drafts import Moment
from dray.gateway.routes.search import Words
from dray.store import Store, Work
from dray.store.factory.alert_history import AlertFilter, AlertRow

router = APIRouter(tags=["alerts"])

ROWS_AT_ONCE = 1_000
"""Alerts per read for a table."""

COLUMNS = (
    *("number", "id", "kind", "level", "agent", "task", "order", "reference", "since_at_s", "ended_at_s"),
    *("acknowledged_by", "acknowledged_at_s", "acknowledged_until_at_s", "comment", "comment_by"),
)

Number = Annotated[int, msgspec.Meta(ge=0, le=2**63 - 1)]


EXAMPLE = AlertRecord(
    id="machine_error-M8",
    kind="machine_error",
    level="alarm",
    response="repair",
    since_at_s=1_893_456_000.0,
    agent="M8",
    acknowledged_by="Early shift",
    acknowledged_at_s=1_893_456_060.0,
    comment="spindle is ordered",
    comment_by="Early shift",
    number=71,
    ended_at_s=1_893_459_600.0,
    words=(
        AlertWordView(at_s=1_893_456_060.0, by="Early shift", said="taken", comment="spindle is ordered"),
    ),
)


@router.get(
    "/alerts/history",
    responses={200: with_csv(counted_list_of(AlertRecord, "Alerts, the last to begin first"))},
    response_class=Json,
)
async def list_alert_history(
    store: Provided[Store],
    caller: Caller,
    words: Words,
    kind: AlertKind | None = None,
    level: Literal["", "alarm", "warning"] = "",
    state: Annotated[Literal["", "lasting", "ended"], Query(description="Only those")] = "",
    since: Annotated[
        Moment | None, Query(description="Still there then, or later, in ISO 8601 with its zone")
    ] = None,
    before: Annotated[Moment | None, Query(description="Begun before then")] = None,
    cursor: Cursor = None,
    limit: Limit = PAGE,
    format: Format = "json",  # noqa: A002 - the word that others use
) -> Response:
    """All stored alerts with their comments, found by words, filters and times."""
    wanted = AlertFilter(
        kind=kind or "",
        level=level,
        lasting=None if state == "" else state == "lasting",
        since_s=None if since is None else since.timestamp(),
        before_s=None if before is None else before.timestamp(),
        orders=caller.may(Scope.ORDERS_READ),
        words=words,
    )
    if format == "csv":
        return table("alerts", [*header_of(COLUMNS), "cause", "words"], _rows(store, wanted))
    after = read_cursor(cursor, tuple[float, Number])
    async with store.read() as work:
        records, last = await _page(work, wanted, after, limit)
        is_all = cursor is None and last is None
        total = len(records) if is_all else None if words else await work.alerts.total(wanted)
    return counted(records, None if last is None else write_cursor(*last), total)


async def _page(
    work: Work, wanted: AlertFilter, after: tuple[float, int] | None, limit: int
) -> tuple[list[AlertRecord], tuple[float, int] | None]:
    """One page of alerts and the next position; None at the end."""
    rows = await work.alerts.page(wanted, after, limit + 1)
    found = [(row, msgspec.json.decode(row.told, type=AlertView)) for row in rows[:limit]]
    references = await work.orders.references({view.order for _, view in found if view.order})
    last = (rows[limit - 1].since_at_s, rows[limit - 1].number) if len(rows) > limit else None
    return [_record(row, view, references.get(view.order)) for row, view in found], last


async def _rows(store: Store, wanted: AlertFilter) -> AsyncIterator[Row]:
    """All matching alerts as table cells."""
    after: tuple[float, int] | None = None
    while True:
        async with store.read() as work:
            records, after = await _page(work, wanted, after, ROWS_AT_ONCE)
        for record in records:
            cause = "" if record.cause is None else record.cause.text
            yield [*row_of(COLUMNS, record), cause, " | ".join(map(_in_words, record.words))]
        if after is None:
            return


def _in_words(word: AlertWordView) -> str:
    until = "" if word.until_at_s is None else f"until {iso(word.until_at_s)}"
    return " ".join(part for part in (iso(word.at_s), word.by, word.said, until, word.comment) if part)


def _record(row: AlertRow, view: AlertView, reference: str | None) -> AlertRecord:
    told = {name: getattr(view, name) for name in view.__struct_fields__}
    held = row.taken
    told |= {
        "since_at_s": row.since_at_s,
        "acknowledged_by": held.by,
        "acknowledged_at_s": held.at_s if held.by else None,
        "acknowledged_until_at_s": held.until_at_s,
        "came_back": held.came_back or None,
        "comment": held.comment,
        "comment_by": held.comment_by,
    }
    words = tuple(AlertWordView(**msgspec.structs.asdict(word)) for word in row.words)
    return AlertRecord(**told, number=row.number, ended_at_s=row.ended_at_s, reference=reference, words=words)
