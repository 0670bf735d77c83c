"""All past and present tasks: content, carriers, and promises; and each transport's timeline."""

from __future__ import annotations

from collections.abc import AsyncIterator
from typing import Annotated, Literal

import msgspec
from fastapi import APIRouter, Query
from fastapi.responses import Response

from dray.gateway.access.caller import Caller
from dray.gateway.access.gate import missing
from dray.gateway.access.principal import Scope
from dray.gateway.factory.lateness import Hold, holds_of
from dray.gateway.http.csv_tables import Format, Row, header_of, row_of, table, with_csv
from dray.gateway.http.problems import not_found
from dray.gateway.http.provided import Provided
from dray.gateway.http.responses import (
    PAGE,
    Cursor,
    Json,
    Limit,
    counted,
    counted_list_of,
    described,
    problems,
    read_cursor,
    write_cursor,
)
from dray.gateway.live.visibility import goal_alias
from dray.gateway.orders.drafts import Moment
from dray.gateway.orders.timeline import LegView, MomentView, WayOutView
from dray.gateway.orders.transport_timeline import KINDS, TransportTimeline, task_timeline
from dray.gateway.routes.search import NowS, Words
from dray.store import Store
from dray.store.orders.tasks import Place, SortedBy, TaskFilter, TaskRow, TaskState

router = APIRouter(tags=["history"])

ROWS_AT_ONCE = 1_000
"""Tasks per read for a table."""

Id = Annotated[str, Query(max_length=128, pattern=r"^[^\x00]*$")]


class TaskRecord(msgspec.Struct, frozen=True, kw_only=True):
    """A task by its coordinator's reports. Times are wall clock seconds."""

    id: str
    kind: Literal["transport", "production"]
    coordinator: str
    item: str
    quantity: int
    source: str
    destination: str
    goal: str
    order: str
    """Order for which it is made; empty for material."""
    reference: str | None = None
    """The customer's own number of that order."""
    state: TaskState
    carrier: str
    """Vehicle or machine that carries or makes it, or did last."""
    standby: str
    epoch: int
    round: int
    opened_at_s: float
    contracted_at_s: float | None
    promised_at_s: float | None
    """Promised end of its last carrier, reported at the end."""
    deadline_at_s: float
    closed_at_s: float | None
    held: str = ""
    """For a late task: what held up its carrier longest. `waits`, `stopped`, `blocked`, `silent`, `charges`,
    `out`, `starves` or `broken`, as in `GET /api/spells`; empty if nothing did or it is not stored any
    more."""
    held_by: str = ""
    """What it waited for longest, or what was wrong."""
    held_s: float = 0.0
    """Total duration of that."""


EXAMPLE = TaskRecord(
    id="M8.1-214",
    kind="transport",
    coordinator="M8",
    item="housing",
    quantity=60,
    source="S4",
    destination="M8",
    goal="",
    order="",
    reference=None,
    state="delivered",
    carrier="ATV2",
    standby="ATV1",
    epoch=1,
    round=1,
    opened_at_s=1_893_456_000.0,
    contracted_at_s=1_893_456_002.0,
    promised_at_s=1_893_456_080.0,
    deadline_at_s=1_893_456_240.0,
    closed_at_s=1_893_456_077.0,
)

COLUMNS = TaskRecord.__struct_fields__

EVENTS_MOST = 2_000
"""Maximum events read per task, as for an attempt at a plain transport."""


class TaskStory(TransportTimeline, kw_only=True):
    """One transport task with its timeline."""

    transport: TaskRecord


STORY = TaskStory(
    transport=EXAMPLE,
    attempts=(
        WayOutView(
            task="M8.1-214",
            goal="",
            item="housing",
            quantity=60,
            source="S4",
            destination="M8",
            opened_at_s=1_893_456_000.0,
            closed_at_s=1_893_456_077.0,
            outcome="delivered",
            legs=(
                LegView(
                    carrier="ATV2",
                    since_at_s=1_893_456_002.0,
                    aboard_at_s=1_893_456_030.0,
                    until_at_s=1_893_456_077.0,
                ),
            ),
        ),
    ),
    moments=(
        MomentView(kind="called", at_s=1_893_456_000.0, agent="M8", other="M8", item="housing", quantity=60),
    ),
)


@router.get(
    "/tasks/history",
    responses={200: with_csv(counted_list_of(TaskRecord, "Tasks, newest first"))},
    response_class=Json,
)
async def list_task_history(
    store: Provided[Store],
    caller: Caller,
    words: Words,
    now_s: NowS,
    state: Annotated[list[TaskState] | None, Query(description="Only these; may be repeated")] = None,
    kind: Literal["", "transport", "production"] = "",
    item: Id = "",
    order: Id = "",
    since: Annotated[
        Moment | None, Query(description="Opened then or later, in ISO 8601 with its zone")
    ] = None,
    before: Annotated[Moment | None, Query(description="Opened before then")] = None,
    late: Annotated[bool, Query(description="Only those that broke their promise")] = False,
    sort: Annotated[
        SortedBy, Query(description="`work`: open ones first; `late`: by how late they were")
    ] = "opened",
    descending: bool = True,
    cursor: Cursor = None,
    limit: Limit = PAGE,
    format: Format = "json",  # noqa: A002 - the word that others use
) -> Response:
    """All stored tasks, open or ended, found by words, filters and times.

    Without `orders:read`, orders are not shown.
    """
    sees_orders = caller.may(Scope.ORDERS_READ)
    if order and not sees_orders:
        raise missing(caller, Scope.ORDERS_READ)
    wanted = TaskFilter(
        states=state or (),
        kind=kind,
        item=item,
        order=order,
        since_s=None if since is None else since.timestamp(),
        before_s=None if before is None else before.timestamp(),
        late_at_s=now_s if late else None,
        words=words,
    )
    if format == "csv":
        return table("tasks", header_of(COLUMNS), _rows(store, wanted, sort, descending, sees_orders, now_s))
    after = read_cursor(cursor, tuple[float, str])
    records, last = await _page(store, wanted, sort, descending, after, limit, sees_orders, now_s)
    if cursor is None and last is None:
        total: int | None = len(records)
    else:
        async with store.read() as work:
            total = None if words else await work.tasks.total(wanted)
    return counted(records, None if last is None else write_cursor(*last), total)


@router.get(
    "/tasks/{task}/timeline",
    responses={
        200: described(TaskStory, "Who carried it, and what happened", STORY),
        **problems(p404="There is no such task, or nothing is carried in it"),
    },
    response_class=Json,
)
async def task_timeline_of(store: Provided[Store], caller: Caller, now_s: NowS, task: str) -> Json:
    """The timeline of one transport task, even long after its end.

    `called`, `won`, `fetched`, handed over, and takeovers. Production tasks are in their order's timeline.
    """
    async with store.read() as work:
        row = (await work.tasks.many([task])).get(task)
        if row is None or row.kind != "transport":
            raise not_found("task", task, "GET /api/tasks/history?kind=transport")
        rows = await work.events.of_tasks([task], KINDS, EVENTS_MOST + 1)
        references = await work.orders.references({row.order_id} if row.order_id else set())
        holds = await holds_of(work, (row,), now_s)
        beginnings = await work.beginnings.all()
    told = task_timeline(row, rows[:EVENTS_MOST], is_whole=len(rows) <= EVENTS_MOST, beginnings=beginnings)
    record = _record(row, references.get(row.order_id), holds.get(row.id))
    attempts, moments = told.attempts, told.moments
    if not caller.may(Scope.ORDERS_READ):
        record = _without_order(record)
        attempts = tuple(msgspec.structs.replace(each, goal=record.goal) for each in attempts)
        moments = tuple(
            msgspec.structs.replace(each, goal=record.goal if each.goal else "") for each in moments
        )
    return Json(TaskStory(transport=record, attempts=attempts, moments=moments, is_whole=told.is_whole))


async def _page(
    store: Store,
    wanted: TaskFilter,
    sort: SortedBy,
    descending: bool,
    after: Place | None,
    limit: int,
    sees_orders: bool,
    now_s: float,
) -> tuple[list[TaskRecord], Place | None]:
    """One page of tasks and the next position; None at the end."""
    async with store.read() as work:
        found = await work.tasks.page(wanted, after, limit + 1, sort, descending=descending)
        references = await work.orders.references({row.order_id for row, _ in found if row.order_id})
        holds = await holds_of(work, (row for row, _ in found[:limit]), now_s)
    last = found[limit - 1][1] if len(found) > limit else None
    records = [_record(row, references.get(row.order_id), holds.get(row.id)) for row, _ in found[:limit]]
    return (records if sees_orders else [_without_order(each) for each in records]), last


async def _rows(
    store: Store, wanted: TaskFilter, sort: SortedBy, descending: bool, sees_orders: bool, now_s: float
) -> AsyncIterator[Row]:
    """All matching tasks as table cells."""
    after: Place | None = None
    while True:
        records, after = await _page(store, wanted, sort, descending, after, ROWS_AT_ONCE, sees_orders, now_s)
        for record in records:
            yield row_of(COLUMNS, record)
        if after is None:
            return


def _without_order(record: TaskRecord) -> TaskRecord:
    return msgspec.structs.replace(
        record, id=goal_alias(record.id), goal=goal_alias(record.goal), order="", reference=None
    )


def _record(row: TaskRow, reference: str | None, hold: Hold | None) -> TaskRecord:
    known = {name: getattr(row, name) for name in COLUMNS if name in TaskRow.__struct_fields__}
    record = TaskRecord(**known, order=row.order_id, reference=reference)
    if hold is None:
        return record
    return msgspec.structs.replace(record, held=hold.doing, held_by=hold.by, held_s=hold.lasted_s)
