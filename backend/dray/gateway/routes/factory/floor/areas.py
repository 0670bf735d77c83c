"""Areas: pausing all vehicles in one, and resuming them."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Depends, Path
from pydantic import BaseModel, ConfigDict

from dray.gateway.access.audit_log import Noted
from dray.gateway.access.caller import Caller
from dray.gateway.access.gate import missing
from dray.gateway.access.principal import Principal, Scope
from dray.gateway.factory.area_pause import AreaPause, PauseAnswer, Word
from dray.gateway.http.problems import not_found
from dray.gateway.http.provided import Provided
from dray.gateway.http.request_bodies import Line, json_only
from dray.gateway.http.responses import Json, described, problems
from dray.gateway.live.projection import Projection

router = APIRouter(tags=["closures"])

Area = Annotated[str, Path(max_length=128)]

EXAMPLE = PauseAnswer("AREA1", ("c1f0a93be",), (Word("ATV3", True), Word("ATV5", True)))


class PauseRequest(BaseModel):
    """The reason for a pause."""

    model_config = ConfigDict(extra="forbid", json_schema_extra={"examples": [{"reason": "a visitor fell"}]})

    reason: Line
    """Shown in the audit log, and to everybody who sees the closure on a panel."""


@router.post(
    "/areas/{area}/pause",
    dependencies=[Depends(json_only)],
    responses={
        200: described(PauseAnswer, "The area is closed; the word of each vehicle in it", EXAMPLE),
        **problems(
            p403="The caller may not command vehicles",
            p404="There is no such area",
            p409="Too much is closed",
        ),
    },
    response_class=Json,
)
async def pause(
    pauses: Provided[AreaPause],
    projection: Provided[Projection],
    caller: Caller,
    note: Noted,
    area: Area,
    request: PauseRequest,
) -> Json:
    """Pause an area: no vehicle drives into it, and all inside stop. This is no emergency stop."""
    _may(area, projection, caller)
    note.detail["reason"] = request.reason
    answer = await pauses.pause(area, request.reason, caller)
    note.detail["vehicles"] = {word.atv: word.text or "stopped" for word in answer.vehicles}
    return Json(answer)


@router.post(
    "/areas/{area}/go-on",
    responses={
        200: described(
            PauseAnswer, "The area is open; what became of each vehicle that stood in it", EXAMPLE
        ),
        **problems(
            p403="Another site's page asked, or the caller may not command vehicles",
            p404="There is no such area",
        ),
    },
    response_class=Json,
)
async def go_on(
    pauses: Provided[AreaPause],
    projection: Provided[Projection],
    caller: Caller,
    note: Noted,
    area: Area,
) -> Json:
    """Open an area, and resume the vehicles that its pause stopped.

    Vehicles stopped otherwise stay stopped.
    """
    _may(area, projection, caller)
    answer = await pauses.go_on(area, caller)
    note.detail["vehicles"] = {word.atv: word.text or "goes on" for word in answer.vehicles}
    return Json(answer)


def _may(area: str, projection: Projection, caller: Principal) -> None:
    """Require the right to command vehicles from a caller who pauses areas."""
    if area not in projection.site.plant.areas:
        raise not_found("area", area, "GET /api/plant")
    if not caller.may(Scope.VEHICLES_COMMAND):
        raise missing(caller, Scope.VEHICLES_COMMAND)
