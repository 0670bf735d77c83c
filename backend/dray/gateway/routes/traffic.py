"""Traffic: which lanes vehicles use."""

from __future__ import annotations

import msgspec
from fastapi import APIRouter

from dray.gateway.answers import Json, described
from dray.gateway.parts import Gateway
from dray.gateway.projection.traffic import WINDOW_S, LaneTraffic

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
async def get_traffic(gateway: Gateway) -> Json:
    """How often vehicles have passed each lane within the last hour of factory time."""
    return Json(TrafficAnswer(WINDOW_S, tuple(gateway.projection.traffic_at(gateway.wall_s()))))
