"""Alerts: what is wrong now, and who has taken it on."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Path

from dray.gateway.access.caller import Caller
from dray.gateway.factory.alerts import AlertMonitor
from dray.gateway.http.problems import not_found
from dray.gateway.http.provided import Provided
from dray.gateway.http.responses import PAGE, Cursor, Json, Limit, described, list_of, page, problems
from dray.gateway.live.projection import Projection
from dray.gateway.live.views import AlertView, CauseView
from dray.gateway.routes.parameters import Visible

router = APIRouter(tags=["alerts"])

EXAMPLE = AlertView(
    id="machine_error-M8",
    kind="machine_error",
    level="alarm",
    response="repair",
    since_at_s=1_893_456_000.0,
    agent="M8",
    cause=CauseView(detail="spindle", text="spindle"),
)


@router.get(
    "/alerts",
    responses={200: list_of(AlertView, "Alerts, by their ids")},
    response_class=Json,
)
async def list_alerts(
    projection: Provided[Projection], visible: Visible, limit: Limit = PAGE, cursor: Cursor = None
) -> Json:
    """What is wrong at this moment, and what it asks of people. An alert leaves when its cause is gone."""
    alerts = [view for each in projection.alerts.views() if (view := visible.alert(each))]
    alerts.sort(key=lambda alert: alert.id)
    return page(alerts, lambda alert: alert.id, cursor, limit)


@router.post(
    "/alerts/{alert}/acknowledge",
    responses={
        200: described(AlertView, "The alert, with the name of who was first to take it on", EXAMPLE),
        **problems(p404="There is no such alert, or its cause is gone"),
    },
    response_class=Json,
)
async def acknowledge_alert(
    monitor: Provided[AlertMonitor],
    projection: Provided[Projection],
    caller: Caller,
    visible: Visible,
    alert: Annotated[str, Path(max_length=192)],
) -> Json:
    """Say, by your name, that an alert is in good hands. Doing it again changes nothing."""
    known = projection.alerts.get(alert)
    taken = await monitor.acknowledge(alert, caller.name) if known and visible.alert(known) else None
    view = taken and visible.alert(taken)
    if view is None:
        raise not_found("alert", alert, "GET /api/alerts; its cause may be gone")
    return Json(view)
