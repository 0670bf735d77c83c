"""Traffic: which lanes vehicles use."""

from __future__ import annotations

import msgspec
from fastapi import APIRouter

from dray.gateway.http.provided import Now, Provided
from dray.gateway.http.responses import Json, described
from dray.gateway.live.projection import Projection
from dray.gateway.live.projection.figures.traffic import WINDOW_S, LaneTraffic

router = APIRouter(tags=["factory"])


class TrafficAnswer(msgspec.Struct, frozen=True):
    """Passages per lane over the last hour of factory time."""

    window_s: float
    """Factory seconds that were looked at."""
    items: tuple[LaneTraffic, ...]
    """Lanes that were passed at all; a lane for both ways is told once per direction."""


EXAMPLE = TrafficAnswer(WINDOW_S, (LaneTraffic("a1", "a2", 42), LaneTraffic("a2", "a1", 17)))


@router.get(
    "/traffic", responses={200: described(TrafficAnswer, "The traffic", EXAMPLE)}, response_class=Json
)
async def get_traffic(projection: Provided[Projection], now_s: Now) -> Json:
    """How often vehicles have passed each lane within the last hour of factory time."""
    return Json(TrafficAnswer(WINDOW_S, tuple(projection.traffic_at(now_s))))
