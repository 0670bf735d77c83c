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
    """What vehicles did on the lanes: over the last hour of factory time, or in the wall hours that were asked for."""

    window_s: float
    """Seconds that were looked at: of factory time for the last hour, of the wall clock for a period."""
    items: tuple[LaneTraffic, ...]
    """Lanes on which anything happened; a lane for both ways is told once per direction."""
    since_at_s: float | None = None
    """Wall clock: where the period begins, at a whole hour; null for the last hour of factory time."""
    until_at_s: float | None = None
    """Where it ends, at a whole hour, the present one included."""


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
    """How often vehicles have passed each lane, how often they came to a stand there, and for how long.

    Without `since` within the last hour of factory time. A period is looked at by whole wall hours, which are kept for 35
    days; what was counted last is in it within a minute.
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
