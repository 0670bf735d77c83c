"""Tasks: every auction with its bids and outcome."""

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

AT_ONCE = 50
"""Tasks per step of the event loop: some milliseconds if each has 64 bids and its `why` is not computed
yet."""

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
    """Open tasks and the last fifty that ended; `/api/events` has the whole history.

    Each task is shown as it is when written: one that has left the requested states by then is left out.
    """
    after = read_cursor(cursor, tuple[float, str])

    def now(name: str) -> TaskView | None:
        view = _look(projection, visible, name)
        return None if view is None or (state and view.state not in state) else view

    found = [
        (_place(view), name)
        async for name, view in _seen(projection, visible)
        if not state or view.state in state
    ]
    found.sort(reverse=True)
    if format == "csv":
        views = (view for _, name in found if (view := now(name)) is not None)
        return table("tasks", header_of(COLUMNS), (row_of(COLUMNS, view) for view in views))
    wanted = [(place, name) for place, name in found if after is None or place < after]
    last = wanted[limit - 1][0] if len(wanted) > limit else None
    names = [name for _, name in wanted[:limit]]
    return await listing_in_turns(names, now, None if last is None else write_cursor(*last))


@router.get(
    "/tasks/{task}",
    responses={200: described(TaskView, "The task"), **problems(p404="There is no such task")},
    response_class=Json,
)
async def get_task(projection: Provided[Projection], visible: Visible, task: str) -> Json:
    """One task, open or lately ended."""
    # A caller who may not read orders knows goals by aliases, and asks by these.
    if projection.tasks.view(task) is not None:
        view = _look(projection, visible, task)
        if view is not None and view.id == task:
            return Json(view)
    else:
        async for _, view in _seen(projection, visible):
            if view.id == task:
                return Json(view)
    raise not_found("task", task, "GET /api/tasks")


def _look(projection: Projection, visible: Visibility, name: str) -> TaskView | None:
    """A task as the caller sees it now; None if not visible, or no longer kept."""
    whole = projection.tasks.view(name)
    return None if whole is None else visible.task(whole)


async def _seen(projection: Projection, visible: Visibility) -> AsyncIterator[tuple[str, TaskView]]:
    """All tasks by name as the caller sees them; lets other work run, as there may be thousands."""
    for number, name in enumerate(projection.tasks.ids(), 1):
        if (view := _look(projection, visible, name)) is not None:
            yield name, view
        if number % AT_ONCE == 0:
            await asyncio.sleep(0)


def _place(task: TaskView) -> tuple[float, str]:
    return task.opened_at_s, task.id
