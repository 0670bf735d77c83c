"""Tasks: every auction with its bids, and what came of it."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from typing import Annotated, Literal

from fastapi import APIRouter, Query, Response

from dray.gateway.http.csv_tables import Format, header_of, row_of, table, with_csv
from dray.gateway.http.problems import not_found
from dray.gateway.http.provided import Provided
from dray.gateway.http.responses import (
    PAGE,
    Cursor,
    Json,
    Limit,
    described,
    list_of,
    listing_in_turns,
    problems,
    read_cursor,
    write_cursor,
)
from dray.gateway.live.projection import Projection
from dray.gateway.live.views import TaskView
from dray.gateway.live.visibility import Visibility
from dray.gateway.routes.parameters import Visible

router = APIRouter(tags=["factory"])

COLUMNS = (
    *("id", "kind", "coordinator", "item", "quantity", "state", "phase"),
    *("primary", "secondary", "source", "destination", "epoch", "round"),
    *("opened_at_s", "contracted_at_s", "promised_at_s", "deadline_at_s", "closed_at_s"),
    *("goal", "order", "trouble"),
)

AT_ONCE = 500
"""Tasks that are looked at in one step of the event loop: some milliseconds."""

State = Literal["bidding", "contracted", "delivered", "withdrawn"]


@router.get(
    "/tasks",
    responses={200: with_csv(list_of(TaskView, "Open tasks and those that ended last, newest first"))},
    response_class=Json,
)
async def list_tasks(
    projection: Provided[Projection],
    visible: Visible,
    state: Annotated[list[State] | None, Query(description="Only tasks in these states")] = None,
    cursor: Cursor = None,
    limit: Limit = PAGE,
    format: Format = "json",  # noqa: A002 - the word that others use
) -> Response:
    """Open tasks and the last fifty that ended; the whole history is in `/api/events`."""
    after = read_cursor(cursor, tuple[float, str])
    tasks = [view async for view in _seen(projection, visible)]
    tasks.sort(key=_place, reverse=True)
    if format == "csv":
        rows = (row_of(COLUMNS, task) for task in tasks if not state or task.state in state)
        return table("tasks", header_of(COLUMNS), rows)
    wanted = [
        task
        for task in tasks
        if (not state or task.state in state) and (after is None or _place(task) < after)
    ]
    last = wanted[limit - 1] if len(wanted) > limit else None
    return listing_in_turns(wanted[:limit], None if last is None else write_cursor(*_place(last)))


@router.get(
    "/tasks/{task}",
    responses={200: described(TaskView, "The task"), **problems(p404="There is no such task")},
    response_class=Json,
)
async def get_task(projection: Provided[Projection], visible: Visible, task: str) -> Json:
    """One task, open or lately ended."""
    whole = projection.tasks.view(task)
    # Whoever may not read orders knows goals by other names, and asks by these.
    if whole is not None:
        view = visible.task(whole)
        if view is not None and view.id == task:
            return Json(view)
    else:
        async for view in _seen(projection, visible):
            if view.id == task:
                return Json(view)
    raise not_found("task", task, "GET /api/tasks")


async def _seen(projection: Projection, visible: Visibility) -> AsyncIterator[TaskView]:
    """All tasks as the caller sees them, with others' turns between: there may be thousands."""
    for number, task in enumerate(projection.tasks.ids(), 1):
        whole = projection.tasks.view(task)
        if whole is not None and (view := visible.task(whole)) is not None:
            yield view
        if number % AT_ONCE == 0:
            await asyncio.sleep(0)


def _place(task: TaskView) -> tuple[float, str]:
    return task.opened_at_s, task.id
