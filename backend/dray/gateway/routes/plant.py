"""The plant, as in its file."""

from __future__ import annotations

from fastapi import APIRouter

from dray.gateway.http.responses import Json, described
from dray.gateway.routes.parameters import Visible
from dray.plant.model import PlantFile

router = APIRouter(tags=["plant"])


@router.get("/plant", responses={200: described(PlantFile, "The plant")}, response_class=Json)
async def get_plant(visible: Visible) -> Json:
    """Places, lanes, products and fleet, as far as they are in the caller's areas."""
    return Json(visible.plant())
