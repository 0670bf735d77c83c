"""Changes of orders and transports, for other systems."""

from __future__ import annotations

from http import HTTPStatus
from typing import Annotated, Literal

import msgspec
from fastapi import APIRouter, Query

from dray.gateway.access.caller import Caller
from dray.gateway.access.principal import Scope
from dray.gateway.http.problems import Problem
from dray.gateway.http.provided import Provided
from dray.gateway.http.responses import PAGE, Json, Limit, described, iso, problems
from dray.gateway.orders.change_feed import WAIT_S, ChangeFeed
from dray.gateway.orders.transports import PlainTransports
from dray.store.orders.change_log import ORDER, TRANSPORT, Change, Seen
from dray.store.orders.transports import TransportFilter

router = APIRouter(tags=["orders"])

LAST_POSITION = 2**63 - 1
"""The largest integer in SQL."""


class ChangeAnswer(msgspec.Struct, frozen=True, kw_only=True):
    """One change of an order or a transport."""

    position: int
    """Grows with every change."""
    at: str
    kind: str
    """order or transport."""
    id: str
    reference: str | None
    """The customer's own number of an order."""
    status: str
    """Status after this change: GET /api/orders/ID or /api/transports/ID has the rest, in its present
    state."""


class ChangesAnswer(msgspec.Struct, frozen=True, kw_only=True):
    """Changes, oldest first."""

    items: tuple[ChangeAnswer, ...]
    since: int
    """Pass this as `since` next time."""
    more: bool
    """Whether more changes are available now."""


EXAMPLE = ChangesAnswer(
    items=(
        ChangeAnswer(
            position=4711,
            at="2030-01-01T10:37:00Z",
            kind=ORDER,
            id="O-1M9K3X2A4-K7QM",
            reference="PO-1002",
            status="in_production",
        ),
    ),
    since=4711,
    more=False,
)


@router.get(
    "/changes",
    responses={
        200: described(ChangesAnswer, "Changes, oldest first", EXAMPLE),
        **problems(
            p410="What came after `since` is not kept any more, or `since` was not given out",
            p429="The caller waits in as many requests as one may",
        ),
    },
    response_class=Json,
)
async def list_changes(
    feed: Provided[ChangeFeed],
    transports: Provided[PlainTransports],
    caller: Caller,
    since: Annotated[
        int | None,
        Query(ge=0, le=LAST_POSITION, description="`since` of the answer before; left out: from now on"),
    ] = None,
    kind: Annotated[Literal["order", "transport"] | None, Query(description="Only these")] = None,
    wait: Annotated[
        float, Query(ge=0, le=WAIT_S, description="Seconds to wait for a change where there is none yet")
    ] = 0.0,
    limit: Limit = PAGE,
) -> Json:
    """Every change of orders and transports, in the order written, without gaps.

    Begin without `since`: the answer is empty and has the present position. Then read the lists, and
    repeatedly ask for changes since that position, with `wait=30`. Transports are shown as in GET
    /api/transports.
    """
    if since is None:
        return Json(ChangesAnswer(items=(), since=await feed.newest(), more=False))
    own = transports.places_of(caller)
    shown = TransportFilter(
        places=None if own is None else sorted(own),
        caller="" if caller.may(Scope.FACTORY_READ) else caller.key,
    )
    seen = Seen(
        orders=kind != TRANSPORT,
        transports=shown if kind != ORDER and caller.may(Scope.TRANSPORTS_CALL) else None,
    )
    found = await feed.after(since, seen, limit, caller=caller.key, wait_s=wait)
    if found.is_forgotten or found.is_ahead:
        why = (
            f"what came after {since} is older than what is kept (DRAY_EVENTS_DAYS)"
            if found.is_forgotten
            else f"{since} was not given out by this database: it was restored from a backup, or is another one"
        )
        raise Problem(
            HTTPStatus.GONE,
            "changes-forgotten",
            "Changes since then are not kept",
            f"{why}; ask without since, then read GET /api/orders and GET /api/transports anew",
        )
    return Json(ChangesAnswer(items=tuple(map(_answer, found.rows)), since=found.until, more=found.more))


def _answer(row: Change) -> ChangeAnswer:
    return ChangeAnswer(
        position=row.position,
        at=iso(row.at_s),
        kind=row.kind,
        id=row.subject,
        reference=row.reference,
        status=row.status,
    )
