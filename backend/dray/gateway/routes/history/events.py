"""Events: the agents' numbered histories, every bid, refusal and award among them."""

from __future__ import annotations

from typing import Annotated, Any

import msgspec
from fastapi import APIRouter, Query

from dray.gateway.http.problems import FieldError, unusable
from dray.gateway.http.provided import Provided
from dray.gateway.http.responses import PAGE, Cursor, Json, Limit, list_of, listing, read_cursor, write_cursor
from dray.store import Store
from dray.store.history.events import EventFilter, EventRow

router = APIRouter(tags=["history"])

# Without NUL, which no text on PostgreSQL may hold.
Word = Annotated[str, Query(max_length=128, pattern=r"^[^\x00]*$")]
Words = Annotated[list[Word] | None, Query(max_length=50)]

LAST_POSITION = 2**63 - 1
"""The largest number that SQL can hold."""

Position = Annotated[int | None, Query(ge=0, le=LAST_POSITION)]


class EventAnswer(msgspec.Struct, frozen=True):
    """One line of an agent's history."""

    position: int
    """Grows with every event: ask for those `since` the last one that you have."""
    agent: str
    incarnation: int
    number: int
    """1, 2, 3 ... in one incarnation of the agent."""
    at_s: float
    """Wall clock, seconds since 1970."""
    plant_s: float
    """Plant clock, as are all times inside `fact`."""
    kind: str
    task: str | None
    goal: str | None
    order: str | None
    fact: dict[str, Any] | msgspec.Raw
    """What happened; its fields depend on `kind`."""


@router.get("/events", responses={200: list_of(EventAnswer, "Events, oldest first")}, response_class=Json)
async def list_events(
    store: Provided[Store],
    since: Position = None,
    kind: Words = None,
    agent: Words = None,
    task: Word = "",
    order: Word = "",
    newest_first: bool = False,
    cursor: Cursor = None,
    limit: Limit = PAGE,
) -> Json:
    """Events that were kept.

    `since` is the `position` of the last event that you have; `kind` and `agent` may be repeated;
    `order` finds all that happened for an order: its goals, their auctions and transports.
    """
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
    return listing([_answer(row) for row in rows[:limit]], next_cursor)


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
