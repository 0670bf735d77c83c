"""Events: the agents' numbered histories, including bids, refusals and awards."""

from __future__ import annotations

from typing import Annotated, Any

import msgspec
from fastapi import APIRouter, Query
from msgspec.structs import replace

from dray.gateway.access.caller import Caller
from dray.gateway.access.gate import missing
from dray.gateway.access.principal import Scope
from dray.gateway.http.problems import FieldError, unusable
from dray.gateway.http.provided import Provided
from dray.gateway.http.responses import PAGE, Cursor, Json, Limit, list_of, listing, read_cursor, write_cursor
from dray.gateway.live.visibility import goal_alias, order_alias, words_alias
from dray.store import Store
from dray.store.history.events import EventFilter, EventRow

router = APIRouter(tags=["history"])

# Without NUL, which PostgreSQL text cannot hold.
Word = Annotated[str, Query(max_length=128, pattern=r"^[^\x00]*$")]
Words = Annotated[list[Word] | None, Query(max_length=50)]

LAST_POSITION = 2**63 - 1
"""The largest integer in SQL."""

Position = Annotated[int | None, Query(ge=0, le=LAST_POSITION)]


class EventAnswer(msgspec.Struct, frozen=True):
    """One event of an agent's history."""

    position: int
    """Grows with every event: pass the last one received as `since`."""
    agent: str
    incarnation: int
    number: int
    """1, 2, 3 ... within one incarnation of the agent."""
    at_s: float
    """Wall clock, seconds since 1970."""
    plant_s: float
    """Plant clock, like all times inside `fact`."""
    kind: str
    task: str | None
    goal: str | None
    order: str | None
    fact: dict[str, Any] | msgspec.Raw
    """The fact; its fields depend on `kind`."""


@router.get("/events", responses={200: list_of(EventAnswer, "Events, oldest first")}, response_class=Json)
async def list_events(
    store: Provided[Store],
    caller: Caller,
    since: Position = None,
    kind: Words = None,
    agent: Words = None,
    task: Word = "",
    order: Word = "",
    newest_first: bool = False,
    cursor: Cursor = None,
    limit: Limit = PAGE,
) -> Json:
    """Stored events.

    `since` is the `position` of the last event received; `kind` and `agent` may be repeated; `order` finds
    everything for an order: its goals, their auctions and transports. Without `orders:read`, orders and goals
    have aliases, valid until the gateway restarts, and cannot be asked for.
    """
    sees_orders = caller.may(Scope.ORDERS_READ)
    if not sees_orders and (order or goal_alias(task) != task):
        raise missing(caller, Scope.ORDERS_READ)
    if since is not None and (newest_first or cursor is not None):
        raise unusable(FieldError("since", "give it alone, or use cursor or newest_first instead"))
    after = read_cursor(cursor, tuple[Annotated[int, msgspec.Meta(ge=0, le=LAST_POSITION)]])
    wanted = EventFilter(kinds=tuple(kind or ()), agents=tuple(agent or ()), task=task, order=order)
    async with store.read() as work:
        rows = await work.events.page(
            wanted, since if after is None else after[0], limit + 1, newest_first=newest_first
        )
    more = len(rows) > limit
    next_cursor = write_cursor(rows[limit - 1].position) if more else None
    shown = rows[:limit] if sees_orders else map(_without_orders, rows[:limit])
    return listing([_answer(row) for row in shown], next_cursor)


def _answer(row: EventRow) -> EventAnswer:
    return EventAnswer(
        position=row.position,
        agent=row.agent,
        incarnation=row.incarnation,
        number=row.number,
        at_s=row.at_s,
        plant_s=row.plant_s,
        kind=row.kind,
        task=row.task,
        goal=row.goal,
        order=row.order_id,
        fact=row.fact,
    )


def _without_orders(row: EventRow) -> EventRow:
    """An event for a caller who may not read orders."""
    return replace(
        row,
        task=row.task and goal_alias(row.task),
        goal=row.goal and goal_alias(row.goal),
        order_id=row.order_id and order_alias(row.order_id),
        fact=msgspec.Raw(words_alias(bytes(row.fact))),
    )
