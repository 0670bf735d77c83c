"""Waits: vehicles that cannot drive on, which vehicles they wait for, and why."""

from __future__ import annotations

from fastapi import APIRouter

from dray.gateway.http.provided import Provided
from dray.gateway.http.responses import PAGE, Cursor, Json, Limit, list_of, page
from dray.gateway.live.projection import Projection
from dray.gateway.live.reasons import wait_text
from dray.gateway.live.views import WaitCauseView, WaitView
from dray.gateway.routes.parameters import Visible

router = APIRouter(tags=["factory"])

_CAUSE = WaitCauseView(kind="docked", chain=("ATV3", "ATV7"), place="M8", since_at_s=1_893_455_875.0)

EXAMPLE = WaitView(id="ATV5", since_at_s=1_893_455_892.0, place="c2", cause=_CAUSE, text=wait_text(_CAUSE))


@router.get("/waits", responses={200: list_of(WaitView, "Waits, by vehicle")}, response_class=Json)
async def list_waits(
    projection: Provided[Projection], visible: Visible, limit: Limit = PAGE, cursor: Cursor = None
) -> Json:
    """Vehicles that cannot drive on, since when, and the chain of vehicles that they wait for.

    Empty where vehicles drive without right of way.
    """
    waits = [view for each in projection.waits.views() if (view := visible.wait(each))]
    return page(waits, lambda wait: wait.id, cursor, limit)
