"""A whole order: goals and transports over time, expected delivery, and the customer's links."""

from __future__ import annotations

from http import HTTPStatus

import msgspec
from fastapi import APIRouter, Depends

from dray.gateway.access.audit_log import Noted
from dray.gateway.http.problems import not_found
from dray.gateway.http.provided import Now, Provided
from dray.gateway.http.public_urls import BaseUrl
from dray.gateway.http.request_bodies import json_or_nothing
from dray.gateway.http.responses import Json, described, problems
from dray.gateway.live.projection import Projection
from dray.gateway.live.projection.orders import goals_before
from dray.gateway.orders.order_ids import new_token
from dray.gateway.orders.timeline import (
    LegView,
    MomentView,
    OrderGoalView,
    TimelineView,
    WayOutView,
    timeline,
)
from dray.gateway.routes.orders.links import (
    NO_END,
    LinkDraft,
    LinksRevoked,
    LinkView,
    NewLink,
    link_view,
    too_many_links,
)
from dray.gateway.tracking.facts import facts_of_order
from dray.gateway.tracking.reasons import Doing
from dray.gateway.tracking.track import Facts, track
from dray.store import Store
from dray.store.history.events import EventFilter
from dray.store.orders.estimates import EstimateCause
from dray.store.orders.order_histories import KINDS, together
from dray.store.orders.tracking_links import Link

router = APIRouter(tags=["orders"])

EVENTS_MOST = 5_000
"""Maximum events read per order: 1,000 pieces with their transports, including some takeovers."""


class ExpectedView(msgspec.Struct, frozen=True):
    """Expected delivery of an order (wall clock, seconds)."""

    from_at_s: float
    to_at_s: float


class EstimateView(msgspec.Struct, frozen=True):
    """An earlier estimate of the delivery. Times are wall clock seconds."""

    at_s: float
    from_at_s: float | None
    """None if there was no estimate."""
    to_at_s: float | None
    cause: EstimateCause
    """Cause of the move: `first`, `changed` (by people), `moved` (to another machine), `stands`, `silent` or
    `material` (of a machine), `passed` (by another order), `replaced` (a carrier), `held_up` (its goods),
    `no_machine`, `later`, `sooner`, `closer` (more exact), `again`, `unknown`."""
    agent: str
    """The machine or vehicle concerned; for `replaced` and `moved`, the earlier one."""
    other: str
    """For `replaced` and `moved` the successor, for `material` the missing material, for `passed` the other
    order."""


class OrderStory(TimelineView, kw_only=True):
    """The timeline of an order, its estimates, and its customer's links."""

    expected: ExpectedView | None = None
    """None if no honest estimate is possible, and after the end."""
    estimates: tuple[EstimateView, ...] = ()
    """Earlier estimates, oldest first: one for each move of an end by more than the rounding step."""
    late: str = ""
    """Estimate against the due time: `maybe`, `yes`, or empty."""
    links: tuple[LinkView, ...] = ()
    """Newest first."""


EXAMPLE = OrderStory(
    goals=(
        OrderGoalView(
            goal="O-1M9K3X2A4-K7QM-1.1",
            product="P1",
            quantity=5,
            machine="M4",
            made=5,
            taken_at_s=1_893_456_000.0,
            begun_at_s=1_893_456_060.0,
            last_at_s=1_893_456_300.0,
            promised_at_s=1_893_456_400.0,
            first_promised_at_s=1_893_456_250.0,
            came_before=2,
        ),
    ),
    transports=(
        WayOutView(
            task="M4.1-3",
            goal="O-1M9K3X2A4-K7QM-1.1",
            item="P1",
            quantity=5,
            source="M4",
            destination="DELIVERY",
            opened_at_s=1_893_456_300.0,
            legs=(LegView(carrier="ATV1", since_at_s=1_893_456_310.0, aboard_at_s=1_893_456_350.0),),
        ),
    ),
    moments=(
        MomentView(
            kind="planned",
            at_s=1_893_456_000.0,
            goal="O-1M9K3X2A4-K7QM-1.1",
            agent="M4",
            item="P1",
            quantity=5,
        ),
    ),
    expected=ExpectedView(1_893_456_420.0, 1_893_456_480.0),
    estimates=(
        EstimateView(1_893_456_010.0, 1_893_456_360.0, 1_893_456_420.0, "first", "", ""),
        EstimateView(1_893_456_200.0, 1_893_456_420.0, 1_893_456_540.0, "material", "M4", "bearing"),
    ),
    links=(LinkView(1_893_456_000.0, None, None),),
)


@router.get(
    "/orders/{order}/timeline",
    responses={
        200: described(OrderStory, "Goals, transports and what happened, oldest first"),
        **problems(p404="There is no such order"),
    },
    response_class=Json,
)
async def order_timeline(
    store: Provided[Store], projection: Provided[Projection], now_s: Now, order: str
) -> Json:
    """A whole order from start to end.

    Read from agents' histories, and from the order's own copy of forgotten ones.
    """
    async with store.read() as work:
        found = await work.orders.get(order)
        if found is None:
            raise not_found("order", order, "GET /api/orders")
        facts = await facts_of_order(projection, work, found, now_s)
        rows = await work.events.page(
            EventFilter(kinds=KINDS, order=order), None, EVENTS_MOST + 1, newest_first=False
        )
        kept = await work.order_histories.of_order(order)
        links = await work.links.to(order)
        estimates = await work.estimates.of_order(order)
        beginnings = await work.beginnings.all()
    told = timeline(
        together(kept, rows[:EVENTS_MOST]),
        facts.goals,
        is_whole=len(rows) <= EVENTS_MOST,
        speed=projection.speed,
        beginnings=beginnings,
    )
    for goal in told.goals:
        _add_present(goal, facts, projection)
    tracked = track(facts)
    expected = None if tracked.eta is None else ExpectedView(tracked.eta.from_s, tracked.eta.to_s)
    return Json(
        OrderStory(
            goals=told.goals,
            transports=told.transports,
            moments=told.moments,
            is_whole=told.is_whole,
            expected=expected,
            estimates=tuple(EstimateView(**msgspec.structs.asdict(each)) for each in estimates),
            late=tracked.late.value,
            links=tuple(map(link_view, links)),
        )
    )


def _add_present(goal: OrderGoalView, facts: Facts, projection: Projection) -> None:
    """Add what its machine does now to an unfinished goal."""
    doing = facts.doings.get(goal.goal)
    machine = projection.machines.view(goal.machine)
    if doing is None or machine is None or goal.ended or goal.made >= goal.quantity:
        return
    goal.doing = doing.value
    if doing is Doing.MAKING:
        goal.doing_since_at_s = projection.orders.work_since_s(goal.goal)
    elif doing is Doing.BUSY:
        goal.behind = goals_before(goal.goal, machine.goals)


@router.post(
    "/orders/{order}/links",
    status_code=HTTPStatus.CREATED,
    dependencies=[Depends(json_or_nothing)],
    responses={
        201: described(NewLink, "The link"),
        **problems(p404="There is no such order", p409="As many links lead to its page as may be"),
    },
    response_class=Json,
)
async def make_link(
    store: Provided[Store],
    base: BaseUrl,
    now_s: Now,
    note: Noted,
    order: str,
    draft: LinkDraft = NO_END,
) -> Json:
    """Create another link to an order's customer page."""
    token, ends_s = new_token(), draft.ends_s(now_s)
    async with store.write() as work:
        if await work.orders.get(order) is None:
            raise not_found("order", order, "GET /api/orders")
        if not await work.links.add_another(token, Link(order, now_s, expires_at_s=ends_s)):
            raise too_many_links("order", order)
    note.detail["days"] = draft.days
    return Json(NewLink(f"{base}/track/{token}", ends_s), HTTPStatus.CREATED)


@router.delete(
    "/orders/{order}/links",
    responses={
        200: described(LinksRevoked, "How many were taken back by this"),
        **problems(p404="There is no such order"),
    },
    response_class=Json,
)
async def revoke_links(store: Provided[Store], now_s: Now, note: Noted, order: str) -> Json:
    """Revoke all links of an order, including the first one; their pages say so from now on."""
    async with store.write() as work:
        if await work.orders.get(order) is None:
            raise not_found("order", order, "GET /api/orders")
        count = await work.links.revoke_all(order, now_s)
    note.detail["links"] = count
    return Json(LinksRevoked(count))
