"""The plant, as its file describes it."""

from __future__ import annotations

from fastapi import APIRouter

from dray.gateway.http.responses import Json, described
from dray.gateway.routes.parameters import Visible
from dray.plant.model import PlantFile

router = APIRouter(tags=["plant"])


@router.get("/plant", responses={200: described(PlantFile, "The plant")}, response_class=Json)
async def get_plant(visible: Visible) -> Json:
    """What stands where, lanes, products, fleet; of it all, what lies in the caller's areas."""
    return Json(visible.plant())
