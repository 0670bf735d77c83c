"""Traffic: which lanes vehicles use, and where they wait."""

from __future__ import annotations

import msgspec
from fastapi import APIRouter

from dray.gateway.factory.figure_sampler import KEPT_S
from dray.gateway.http.problems import FieldError, unusable
from dray.gateway.http.provided import Now, Provided
from dray.gateway.http.responses import Json, described
from dray.gateway.live.projection import Projection
from dray.gateway.live.projection.figures.traffic import WINDOW_S
from dray.gateway.orders.drafts import Moment
from dray.store import Store
from dray.store.factory.lane_traffic import HOUR_S, LaneTraffic

router = APIRouter(tags=["factory"])


class TrafficAnswer(msgspec.Struct, frozen=True):
    """Traffic on the lanes: over the last factory hour, or in the requested wall hours."""

    window_s: float
    """Length of the period: factory seconds for the last hour, else wall seconds."""
    items: tuple[LaneTraffic, ...]
    """Lanes with traffic; a two-way lane is listed once per direction."""
    since_at_s: float | None = None
    """Begin of the period at a whole hour, wall clock; null for the last factory hour."""
    until_at_s: float | None = None
    """End of the period at a whole hour, including the present one."""


EXAMPLE = TrafficAnswer(WINDOW_S, (LaneTraffic("a1", "a2", 42, 3, 12.5), LaneTraffic("a2", "a1", 17)))


@router.get(
    "/traffic", responses={200: described(TrafficAnswer, "The traffic", EXAMPLE)}, response_class=Json
)
async def get_traffic(
    projection: Provided[Projection],
    store: Provided[Store],
    now_s: Now,
    since: Moment | None = None,
    until: Moment | None = None,
) -> Json:
    """How often vehicles passed each lane, how often they stood there, and for how long.

    Without `since`, within the last factory hour. Other periods are whole wall hours, stored for 35 days; the
    latest counts appear within a minute.
    """
    if since is None:
        if until is not None:
            raise unusable(FieldError("since", "say since when, too"))
        return Json(TrafficAnswer(WINDOW_S, tuple(projection.traffic_at(now_s))))
    until_s = now_s if until is None else until.timestamp()
    begin_s, end_s = since.timestamp() // HOUR_S * HOUR_S, -(-until_s // HOUR_S) * HOUR_S
    if end_s <= begin_s:
        raise unusable(FieldError("until", "it is not after since; give a later moment"))
    if end_s - begin_s > KEPT_S + HOUR_S:
        reason = f"traffic is kept for {KEPT_S / 86_400:g} days; ask for no more"
        raise unusable(FieldError("since", reason))
    async with store.read() as work:
        found = await work.lane_hours.between(begin_s, end_s)
    return Json(TrafficAnswer(end_s - begin_s, tuple(found), begin_s, end_s))
