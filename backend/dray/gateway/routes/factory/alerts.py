"""Alerts: what is wrong now, and who has taken it on."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Path
from pydantic import BaseModel, ConfigDict, Field

from dray.gateway.access.audit_log import Noted
from dray.gateway.access.caller import Caller
from dray.gateway.factory.alerts import AlertMonitor
from dray.gateway.http.problems import FieldError, not_found, unusable
from dray.gateway.http.provided import Provided
from dray.gateway.http.request_bodies import NOTE
from dray.gateway.http.responses import PAGE, Cursor, Json, Limit, described, list_of, page, problems
from dray.gateway.live.projection import Projection
from dray.gateway.live.views import AlertView, CauseView
from dray.gateway.orders.drafts import Moment
from dray.gateway.routes.parameters import Visible
from dray.gateway.routes.search import NowS

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


SNOOZE_MAX_S = 7 * 86_400.0
"""Maximum wall seconds of an acknowledgement: a longer trouble needs a new look."""


class AcknowledgeRequest(BaseModel):
    """A person's comment on an alert that they take on."""

    model_config = ConfigDict(
        extra="forbid",
        json_schema_extra={
            "examples": [{"comment": "fitter comes at two", "until_at": "2030-01-01T14:00:00+01:00"}]
        },
    )

    comment: Annotated[str, Field(max_length=500, pattern=NOTE)] = ""
    """One line; empty for none."""
    until_at: Moment | None = None
    """End of the acknowledgement, in ISO 8601 with its zone, within seven days; left out for as long as the
    alert lasts. Then the alert asks again, and sooner when it is worse."""


NO_WORD = AcknowledgeRequest()


@router.get(
    "/alerts",
    responses={200: list_of(AlertView, "Alerts, by their ids")},
    response_class=Json,
)
async def list_alerts(
    projection: Provided[Projection], visible: Visible, limit: Limit = PAGE, cursor: Cursor = None
) -> Json:
    """Present alerts, and what they ask of people. An alert leaves when its cause is gone."""
    alerts = [view for each in projection.alerts.views() if (view := visible.alert(each))]
    alerts.sort(key=lambda alert: alert.id)
    return page(alerts, lambda alert: alert.id, cursor, limit)


@router.post(
    "/alerts/{alert}/acknowledge",
    responses={
        200: described(AlertView, "The alert, with the name of who was first to take it on", EXAMPLE),
        **problems(
            p404="There is no such alert, or its cause is gone",
            p409="Somebody else has taken it on, and says until when",
            p422="That moment is past, or too far away",
        ),
    },
    response_class=Json,
)
async def acknowledge_alert(
    monitor: Provided[AlertMonitor],
    projection: Provided[Projection],
    caller: Caller,
    visible: Visible,
    note: Noted,
    now_s: NowS,
    alert: Annotated[str, Path(max_length=192)],
    request: AcknowledgeRequest = NO_WORD,
) -> Json:
    """Take on an alert by your name, until when, and why. Repeating it changes nothing.

    The first person keeps it, and may change the end. Comments of others are stored too.
    """
    comment, until_at_s = request.comment.strip(), None
    if request.until_at is not None:
        until_at_s = request.until_at.timestamp()
        if not now_s < until_at_s <= now_s + SNOOZE_MAX_S:
            raise unusable(FieldError.of("until_at", "more_than_a_week"))
    note.detail |= request.model_dump(mode="json", exclude_defaults=True)
    known = projection.alerts.get(alert)
    taken = (
        known and visible.alert(known) and await monitor.acknowledge(alert, caller.name, comment, until_at_s)
    )
    view = taken and visible.alert(taken)
    if view is None:
        raise not_found("alert", alert, "its cause may be gone; GET /api/alerts")
    return Json(view)
