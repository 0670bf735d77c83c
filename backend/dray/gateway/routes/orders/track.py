"""The customer's view of an order or plain transport for programs: no login, no names, no vehicles."""

from __future__ import annotations

from http import HTTPStatus
from typing import Annotated

from fastapi import APIRouter, Path

from dray.gateway.http.problems import Problem
from dray.gateway.http.provided import Now, Provided
from dray.gateway.http.responses import Json, described, problems
from dray.gateway.live.projection import Projection
from dray.gateway.orders.transport_steps import transport_steps
from dray.gateway.tracking.answer import TrackAnswer, answer
from dray.gateway.tracking.facts import NoPage, facts_of
from dray.gateway.tracking.track import track
from dray.gateway.tracking.transport import TransportTrackAnswer, transport_of, transport_track
from dray.store import Store

router = APIRouter(tags=["orders"])

PRIVATE = {
    # Only holders of the link see the page; search engines and caches must not store it.
    "X-Robots-Tag": "noindex, nofollow",
    "Cache-Control": "private, no-store",
    # Pages linked from it must not learn the address.
    "Referrer-Policy": "no-referrer",
}
"""Headers of everything behind a link."""

TRANSPORT = TransportTrackAnswer(
    status="assigned",
    item="bearing",
    name="Bearing",
    quantity=40,
    source="S5",
    to="M8",
    wait=None,
    expected_at="2030-01-01T10:44:00Z",
    late=False,
    created_at="2030-01-01T10:37:00Z",
    assigned_at="2030-01-01T10:37:05Z",
    not_before=None,
    due_at="2030-01-01T10:52:00Z",
    ended_at=None,
)


@router.get(
    "/track/{token}",
    responses={
        200: described(TrackAnswer, "The customer's view"),
        **problems(p404="There is no such page", p410="The link was taken back, or has expired"),
    },
    response_class=Json,
)
async def track_order(
    store: Provided[Store],
    projection: Provided[Projection],
    now_s: Now,
    token: Annotated[str, Path(max_length=64)],
) -> Json:
    """An order, by its token."""
    found = await facts_of(store, projection, token, now_s)
    if found.facts is None:
        raise _no_page(found.why or NoPage.UNKNOWN, token)
    return Json(answer(track(found.facts)), headers=PRIVATE)


@router.get(
    "/track/transports/{token}",
    responses={
        200: described(TransportTrackAnswer, "What whoever has the link is told", TRANSPORT),
        **problems(p404="There is no such page", p410="The link was taken back, or has expired"),
    },
    response_class=Json,
)
async def track_transport(
    store: Provided[Store],
    projection: Provided[Projection],
    now_s: Now,
    token: Annotated[str, Path(max_length=64)],
) -> Json:
    """A plain transport, by its token."""
    found = await transport_of(store, token, now_s)
    if found.row is None:
        raise _no_page(found.why or NoPage.UNKNOWN, token)
    name = found.row.thing or material_name(projection, found.row.item)
    steps = await transport_steps(store, found.row)
    return Json(transport_track(found.row, steps, name, now_s), headers=PRIVATE)


def material_name(projection: Projection, item: str) -> str:
    """The name of a material for people."""
    spec = projection.site.plant.materials.get(item)
    return item if spec is None else spec.name


def _no_page(why: NoPage, token: str) -> Problem:
    if why is NoPage.UNKNOWN:
        problem = Problem(
            HTTPStatus.NOT_FOUND,
            "unknown-tracking-page",
            "There is no such page",
            f"nothing has the link {token!r}; look whether all of it was copied, or ask for a new one",
        )
    else:
        problem = Problem(
            HTTPStatus.GONE,
            "tracking-link-ended",
            "The link has ended",
            f"it is {why.value}; ask whoever sent it for a new one",
        )
    problem.headers.update(PRIVATE)
    return problem
