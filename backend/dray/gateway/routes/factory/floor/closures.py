"""Closures: lanes, places and areas that people close to vehicles, make slow or one-way."""

from __future__ import annotations

from http import HTTPStatus
from typing import Annotated

from fastapi import APIRouter, Depends, Path
from pydantic import AwareDatetime, BaseModel, ConfigDict, Field

from dray.gateway.access.audit_log import Noted
from dray.gateway.access.caller import Caller
from dray.gateway.access.principal import Principal
from dray.gateway.factory.closings import Closings, Outlook
from dray.gateway.http.problems import FieldError, unusable
from dray.gateway.http.provided import Provided
from dray.gateway.http.request_bodies import Line, json_only
from dray.gateway.http.responses import PAGE, Cursor, Json, Limit, described, list_of, page, problems
from dray.gateway.live.projection import Projection
from dray.gateway.live.views import ClosureView, LaneView
from dray.messages import ClosureKind
from dray.messages.floor.closure import SLOWEST_MPS
from dray.plant import Plant
from dray.store.factory.closures import ClosureRow

router = APIRouter(tags=["closures"])

LONGEST_S = 365 * 86400.0
"""Until then at most; what is closed for longer has no end yet."""

Name = Annotated[str, Field(min_length=1, max_length=128)]

EXAMPLE = ClosureView(
    id="c1f0a93be",
    kind="closed",
    lane=LaneView(start="c3", end="m5-lane"),
    until_at_s=1_893_463_200.0,
    reason="oil on the floor",
    by="Maria Weber",
    at_s=1_893_456_000.0,
    lanes=(LaneView(start="c3", end="m5-lane"), LaneView(start="m5-lane", end="c3")),
)


class LaneRequest(BaseModel):
    """A lane of the plant, by the nodes at its ends."""

    model_config = ConfigDict(extra="forbid")

    start: Name
    end: Name


class ClosureRequest(BaseModel):
    """What is closed, how, why and until when. Exactly one of `lane`, `place` and `area` is named."""

    model_config = ConfigDict(
        extra="forbid",
        json_schema_extra={
            "examples": [
                {
                    "kind": "closed",
                    "lane": {"start": "c3", "end": "m5-lane"},
                    "until": "2030-01-01T02:00:00Z",
                    "reason": "oil on the floor",
                },
                {"kind": "slow", "area": "area1", "speed_mps": 0.5, "reason": "visitors"},
            ]
        },
    )

    kind: ClosureKind = ClosureKind.CLOSED
    lane: LaneRequest | None = None
    """In both directions, also where these are two lanes beside one another, unless it becomes one-way: then vehicles drive from
    `start` to `end` only."""
    place: Name | None = None
    """A node, a crossing, or a machine, storage, warehouse, charger or parking place, whose dock it is."""
    area: Name | None = None
    speed_mps: Annotated[float, Field(ge=SLOWEST_MPS, le=100.0, allow_inf_nan=False)] | None = None
    """For `slow`: the highest speed."""
    until: AwareDatetime | None = None
    """When it ends by itself; left out, when somebody ends it."""
    reason: Line
    """For the audit log, and for everybody who sees the closure on a panel."""


@router.get("/closures", responses={200: list_of(ClosureView, "What is closed, by id")}, response_class=Json)
async def list_closures(projection: Provided[Projection], cursor: Cursor = None, limit: Limit = PAGE) -> Json:
    """What people have closed to vehicles: by whose decision, why, until when, and which lanes that concerns."""
    views = sorted(projection.closures.views(), key=lambda view: view.id)
    return page(views, lambda view: view.id, cursor, limit)


@router.post(
    "/closures",
    status_code=HTTPStatus.CREATED,
    dependencies=[Depends(json_only)],
    responses={
        200: described(ClosureView, "It holds already, for the same time: the first decision", EXAMPLE),
        201: described(ClosureView, "It holds", EXAMPLE)
        | {"headers": {"Location": {"description": "The closure", "schema": {"type": "string"}}}},
        **problems(p409="Too much is closed"),
    },
    response_class=Json,
)
async def close(
    closings: Provided[Closings],
    projection: Provided[Projection],
    caller: Caller,
    note: Noted,
    request: ClosureRequest,
) -> Json:
    """Close a lane, a place or an area to vehicles, or make it slow, or a lane one-way; at once.

    Vehicles inside leave, all others go round; bids and promises follow. Sent twice it is one closure. `cut_off` names
    places that no vehicle gets to any more; ask `POST /api/closures/preview` before, where that matters.
    """
    note.detail |= request.model_dump(mode="json", exclude_none=True)
    wanted = _row(request, projection.site.plant, caller, closings.now_s)
    view, is_new = await closings.close(wanted)
    note.target, note.detail["cut_off"] = view.id, view.cut_off
    where = {"Location": f"/api/closures/{view.id}"}
    return Json(view, HTTPStatus.CREATED if is_new else HTTPStatus.OK, headers=where if is_new else None)


@router.post(
    "/closures/preview",
    dependencies=[Depends(json_only)],
    responses={
        200: described(
            Outlook, "What it would cut off, and whom it would shut in", Outlook(cut_off=("M5",), shut_in=())
        ),
        **problems(),
    },
    response_class=Json,
)
async def preview(
    closings: Provided[Closings], projection: Provided[Projection], caller: Caller, request: ClosureRequest
) -> Json:
    """What a closure would mean, together with those that hold. Nothing is closed."""
    return Json(closings.preview(_row(request, projection.site.plant, caller, closings.now_s)))


@router.delete(
    "/closures/{closure}",
    responses={
        200: described(ClosureView, "It has ended; what it was", EXAMPLE),
        **problems(p403="Another site's page asked", p404="There is no such closure"),
    },
    response_class=Json,
)
async def end(
    closings: Provided[Closings], note: Noted, closure: Annotated[str, Path(max_length=128)]
) -> Json:
    """Open what a closure has closed; at once."""
    ended = await closings.open(closure)
    note.detail["closed_for"] = ended.reason
    return Json(ended)


def _row(request: ClosureRequest, plant: Plant, caller: Principal, now_s: float) -> ClosureRow:
    """The decision that a request asks for.

    Raises:
        Problem: 422, with every field that cannot be used.
    """
    request = request.model_copy(update={"lane": _driven(request.lane, plant)})
    faults = [*_extent_faults(request, plant), *_kind_faults(request, plant)]
    until_s = None if request.until is None else request.until.timestamp()
    if until_s is not None and until_s <= now_s:
        faults.append(FieldError("until", "this time has passed: name a later one, or leave it out"))
    elif until_s is not None and until_s > now_s + LONGEST_S:
        faults.append(
            FieldError("until", "that is more than a year from now: leave it out, and open it then")
        )
    if faults:
        raise unusable(*faults)
    return ClosureRow(
        id="",
        kind=request.kind.value,
        start_node="" if request.lane is None else request.lane.start,
        end_node="" if request.lane is None else request.lane.end,
        place=request.place or "",
        area=request.area or "",
        speed_mps=request.speed_mps,
        until_s=until_s,
        reason=request.reason,
        by=caller.name,
        person=f"{caller.kind}:{caller.id}",
        at_s=now_s,
    )


def _driven(lane: LaneRequest | None, plant: Plant) -> LaneRequest | None:
    """The lane that is meant: of a two-lane road that is named against the direction of one lane, the lane beside it."""
    if lane is None or plant.roads.lane(lane.start, lane.end) is not None:
        return lane
    start, end = plant.way_back(lane.end, lane.start)
    there, back = plant.roads.lane(lane.end, lane.start), plant.roads.lane(start, end)
    return lane if there is None or back is None else LaneRequest(start=start, end=end)


def _extent_faults(request: ClosureRequest, plant: Plant) -> list[FieldError]:
    lane, place, area = request.lane, request.place, request.area
    if sum(named is not None for named in (lane, place, area)) != 1:
        return [FieldError("lane", "name exactly one of lane, place and area")]
    if lane is not None and plant.roads.lane(lane.start, lane.end) is None:
        if plant.roads.lane(lane.end, lane.start) is not None:
            reason = f"the lane runs from {lane.end} to {lane.start} only"
        else:
            reason = f"no lane joins {lane.start} and {lane.end}; GET /api/plant has the lanes"
        return [FieldError("lane", reason)]
    if place is not None and not any(
        place in known for known in (plant.nodes, plant.crossings, plant.places)
    ):
        return [FieldError("place", f"there is no node or place {place}; GET /api/plant has them")]
    if area is not None and area not in plant.areas:
        known = ", ".join(plant.areas) or "none"
        return [FieldError("area", f"there is no area {area}; there are: {known}")]
    return []


def _kind_faults(request: ClosureRequest, plant: Plant) -> list[FieldError]:
    faults = []
    if request.kind is ClosureKind.SLOW and request.speed_mps is None:
        faults.append(FieldError("speed_mps", "say how fast vehicles may drive where it is slow"))
    elif request.kind is not ClosureKind.SLOW and request.speed_mps is not None:
        faults.append(FieldError("speed_mps", "only what is slow has a speed"))
    if request.kind is ClosureKind.ONE_WAY:
        lane = request.lane
        if lane is None:
            faults.append(FieldError("lane", "only a lane can be one-way: name it"))
        elif (
            plant.roads.lane(lane.start, lane.end)
            and plant.roads.lane(*plant.way_back(lane.start, lane.end)) is None
        ):
            faults.append(FieldError("lane", "this lane is one-way already"))
    return faults
