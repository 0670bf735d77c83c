"""The plant, as its file describes it."""

from __future__ import annotations

from fastapi import APIRouter

from dray.gateway.answers import Json, described
from dray.gateway.parts import Gateway
from dray.plant.model import PlantFile

router = APIRouter(tags=["plant"])


@router.get("/plant", responses={200: described(PlantFile, "The plant")}, response_class=Json)
async def get_plant(gateway: Gateway) -> Json:
    """The whole plant: what stands where, lanes, products, fleet."""
    return Json(gateway.plant)
