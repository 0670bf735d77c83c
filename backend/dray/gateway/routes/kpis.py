"""The factory's figures."""

from __future__ import annotations

from fastapi import APIRouter

from dray.gateway.answers import Json, described
from dray.gateway.parts import Gateway
from dray.gateway.views import FactoryView

router = APIRouter(tags=["factory"])


@router.get("/kpis", responses={200: described(FactoryView, "The figures")}, response_class=Json)
async def get_kpis(gateway: Gateway) -> Json:
    """The factory's figures at this moment."""
    return Json(gateway.projection.factory(gateway.wall_s()))
