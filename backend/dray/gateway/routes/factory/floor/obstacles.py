"""Obstacles that vehicles met on lanes, and a person's report that one is gone."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Depends
from pydantic import BaseModel, ConfigDict, Field

from dray.gateway.access.audit_log import Noted
from dray.gateway.access.caller import Caller
from dray.gateway.http.problems import not_found
from dray.gateway.http.provided import Provided
from dray.gateway.http.request_bodies import json_only
from dray.gateway.http.responses import PAGE, Cursor, Json, Limit, described, list_of, page, problems
from dray.gateway.live.peer import Peer
from dray.gateway.live.projection import Projection
from dray.gateway.live.views import ObstacleView
from dray.gateway.routes.parameters import Visible
from dray.messages import ObstacleCleared

router = APIRouter(tags=["factory"])

EXAMPLE = ObstacleView(
    id="c3.to-m5-lane>m5-lane.from-c3",
    start="c3.to-m5-lane",
    end="m5-lane.from-c3",
    by="ATV5",
    at_s=1_893_455_875.0,
    until_at_s=1_893_455_935.0,
)

Node = Annotated[str, Field(min_length=1, max_length=128)]


class ClearedRequest(BaseModel):
    """A lane that is free again, by the nodes at its ends; both directions are meant."""

    model_config = ConfigDict(
        extra="forbid", json_schema_extra={"examples": [{"start": "c3.to-m5-lane", "end": "m5-lane.from-c3"}]}
    )

    start: Node
    end: Node


@router.get(
    "/obstacles", responses={200: list_of(ObstacleView, "What lies on lanes, by id")}, response_class=Json
)
async def list_obstacles(
    projection: Provided[Projection], visible: Visible, limit: Limit = PAGE, cursor: Cursor = None
) -> Json:
    """Obstacles on lanes: vehicles go round one until it is gone, or until they forget it and look again."""
    views = [view for each in projection.obstacles.views() if (view := visible.obstacle(each))]
    return page(sorted(views, key=lambda view: view.id), lambda view: view.id, cursor, limit)


@router.post(
    "/obstacles/cleared",
    dependencies=[Depends(json_only)],
    responses={
        200: described(ObstacleView, "All vehicles were told; what was known of it", EXAMPLE),
        **problems(p404="Nothing is known to lie there, or not in the caller's areas"),
    },
    response_class=Json,
)
async def clear(
    projection: Provided[Projection],
    peer: Provided[Peer],
    caller: Caller,
    visible: Visible,
    note: Noted,
    request: ClearedRequest,
) -> Json:
    """Report that a lane is free again.

    Vehicles drive there at once; a body still stops before anything in its way.
    """
    view = projection.obstacles.of(request.start, request.end)
    if view is None or visible.obstacle(view) is None:
        raise not_found("obstacle", f"{request.start}>{request.end}", "GET /api/obstacles")
    note.target = view.id
    said = ObstacleCleared(start=view.start, end=view.end, by=f"{caller.kind}:{caller.id}")
    peer.tell_all(said)
    projection.obstacles.fold(said)
    return Json(view)
