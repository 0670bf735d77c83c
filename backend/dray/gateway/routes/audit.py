"""The audit log: who did what, or tried to, and what came of it."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable
from typing import Annotated, Literal

import msgspec
from fastapi import APIRouter, Query
from fastapi.responses import Response

from dray.gateway.answers import PAGE, Cursor, Json, Limit, list_of, listing, read_cursor, write_cursor
from dray.gateway.parts import Gateway
from dray.store.audit import AuditFilter, AuditRow

router = APIRouter(tags=["access"])

ANSWER = list_of(AuditRow, "Lines, newest first")
ANSWER["content"]["text/csv"] = {"schema": {"type": "string"}}

FORMULA = ("=", "+", "-", "@", "\t", "\r")
"""What begins like this, a spreadsheet would compute."""

LAST_POSITION = 2**63 - 1
"""The largest number that SQL can hold."""

LAST_S = 1e12
"""Some 30,000 years."""

Moment = Annotated[float | None, Query(ge=0, le=LAST_S, description="Seconds since 1970")]
Word = Annotated[str, Query(max_length=128)]


@router.get("/audit", responses={200: ANSWER}, response_class=Json)
async def list_audit(
    gateway: Gateway,
    since: Moment = None,
    until: Moment = None,
    who: Word = "",
    action: Word = "",
    target: Word = "",
    result: Literal["", "done", "refused", "failed"] = "",
    cursor: Cursor = None,
    limit: Limit = PAGE,
    format: Annotated[  # noqa: A002 - the word that others use
        Literal["json", "csv"], Query(description="`csv` for a spreadsheet")
    ] = "json",
) -> Response:
    """What people and other systems did, or tried to do.

    `since` and `until` bound the time; `who`, `action`, `target` and `result` must fit exactly.
    """
    after = read_cursor(cursor, tuple[Annotated[int, msgspec.Meta(ge=0, le=LAST_POSITION)]])
    wanted = AuditFilter(since_s=since, until_s=until, who=who, action=action, target=target, result=result)
    async with gateway.store.read() as work:
        rows = await work.audit.page(wanted, None if after is None else after[0], limit + 1)
    next_cursor = write_cursor(rows[limit - 1].position) if len(rows) > limit else None
    if format == "json":
        return listing(rows[:limit], next_cursor)
    headers = {"Content-Disposition": 'attachment; filename="audit.csv"'}
    return Response(to_csv(rows[:limit]), media_type="text/csv", headers=headers)


def to_csv(rows: Iterable[AuditRow]) -> str:
    """Lines as a table with a line of names; nothing in it is a formula."""
    text = io.StringIO()
    writer = csv.writer(text)
    writer.writerow(AuditRow.__struct_fields__)
    for row in rows:
        fields = msgspec.structs.asdict(row) | {"detail": msgspec.json.encode(row.detail).decode()}
        writer.writerow([_harmless(value) for value in fields.values()])
    return text.getvalue()


def _harmless(value: object) -> object:
    return f"'{value}" if isinstance(value, str) and value.startswith(FORMULA) else value
