"""The plant, as in its file."""

from __future__ import annotations

from fastapi import APIRouter

from dray.gateway.http.provided import Now, Provided
from dray.gateway.http.responses import Json, described
from dray.gateway.live.projection import Projection
from dray.gateway.routes.parameters import Visible
from dray.plant.model import PlantFile

router = APIRouter(tags=["plant"])

AT = "Plant-At-S"
"""Header of the answer: `plant_at_s` of its plant, as the stream tells it."""

_ANSWER = described(PlantFile, "The plant") | {
    "headers": {
        AT: {
            "description": "When this plant became as it is at this gateway: `plant_at_s` of the stream",
            "schema": {"type": "number"},
        }
    }
}


@router.get("/plant", responses={200: _ANSWER}, response_class=Json)
async def get_plant(visible: Visible, projection: Provided[Projection], now_s: Now) -> Json:
    """Places, lanes, products and fleet, as far as they are in the caller's areas."""
    return Json(visible.plant(), headers={AT: repr(projection.plant_at_s(now_s))})
