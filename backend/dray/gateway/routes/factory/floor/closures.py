"""Closures: lanes, places, areas and outlines that people close, slow down or make one-way."""

from __future__ import annotations

from http import HTTPStatus
from typing import Annotated

from fastapi import APIRouter, Depends, Path
from pydantic import AwareDatetime, BaseModel, ConfigDict, Field

from dray.gateway.access.audit_log import Noted
from dray.gateway.access.caller import Caller
from dray.gateway.access.principal import Principal
from dray.gateway.factory.closings import Closings, Outlook, outline_of
from dray.gateway.http.problems import FieldError, unusable
from dray.gateway.http.provided import Provided
from dray.gateway.http.request_bodies import Line, json_only
from dray.gateway.http.responses import PAGE, Cursor, Json, Limit, described, list_of, page, problems
from dray.gateway.live.projection import Projection
from dray.gateway.live.views import ClosureView, LaneView
from dray.messages import ClosureKind
from dray.messages.floor.closure import MAX_CORNERS, SLOWEST_MPS, Corner
from dray.plant import Plant
from dray.plant.floor.geometry import area_m2, crossed_edges
from dray.plant.model import Point
from dray.store.factory.closures import ClosureRow

router = APIRouter(tags=["closures"])

LONGEST_S = 365 * 86400.0
"""Latest end in seconds from now; a longer closure has no end yet."""

Name = Annotated[str, Field(min_length=1, max_length=128)]

EXAMPLE = ClosureView(
    id="c1f0a93be",
    kind="closed",
    lane=LaneView(start="c3.to-m5-lane", end="m5-lane.from-c3"),
    until_at_s=1_893_463_200.0,
    reason="oil on the floor",
    by="Early shift",
    at_s=1_893_456_000.0,
    lanes=(
        LaneView(start="c3.to-m5-lane", end="m5-lane.from-c3"),
        LaneView(start="m5-lane.to-c3", end="c3.from-m5-lane"),
    ),
)


class LaneRequest(BaseModel):
    """A lane of the plant, by the nodes at its ends."""

    model_config = ConfigDict(extra="forbid")

    start: Name
    end: Name


class CornerRequest(BaseModel):
    """A corner, in metres from the lower left corner of the floor, to the centimetre."""

    model_config = ConfigDict(extra="forbid")

    x_m: Annotated[float, Field(allow_inf_nan=False, ge=-1e6, le=1e6)]
    y_m: Annotated[float, Field(allow_inf_nan=False, ge=-1e6, le=1e6)]


class ClosureRequest(BaseModel):
    """A closure: what, how, why and until when.

    Exactly one of `lane`, `place`, `area` and `outline` is set.
    """

    model_config = ConfigDict(
        extra="forbid",
        json_schema_extra={
            "examples": [
                {
                    "kind": "closed",
                    "lane": {"start": "c3.to-m5-lane", "end": "m5-lane.from-c3"},
                    "reason": "oil on the floor",
                },
                {
                    "kind": "closed",
                    "outline": [
                        {"x_m": 10.0, "y_m": 8.0},
                        {"x_m": 22.0, "y_m": 8.0},
                        {"x_m": 16.0, "y_m": 19.0},
                    ],
                    "reason": "a shelf has fallen over",
                },
                {"kind": "slow", "area": "AREA1", "speed_mps": 0.5, "reason": "visitors"},
            ]
        },
    )

    kind: ClosureKind = ClosureKind.CLOSED
    lane: LaneRequest | None = None
    """Both directions, even if these are two lanes side by side. A one-way lane is driven from `start` to
    `end` only."""
    place: Name | None = None
    """A node, a crossing, or a machine, storage, warehouse, charger or parking place, which stands for its
    dock."""
    area: Name | None = None
    outline: Annotated[list[CornerRequest], Field(min_length=3, max_length=MAX_CORNERS)] | None = None
    """A part of the floor by its corners in order: its nodes, and the lanes that cross it."""
    speed_mps: Annotated[float, Field(ge=SLOWEST_MPS, le=100.0, allow_inf_nan=False)] | None = None
    """Speed limit for `slow`."""
    until: AwareDatetime | None = None
    """When it ends by itself; left out if a person ends it."""
    reason: Line
    """Shown in the audit log, and to everybody who sees the closure on a panel."""


@router.get("/closures", responses={200: list_of(ClosureView, "What is closed, by id")}, response_class=Json)
async def list_closures(projection: Provided[Projection], cursor: Cursor = None, limit: Limit = PAGE) -> Json:
    """Closures in force: by whom, why, until when, and which lanes they affect."""
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
    """Close a lane, a place, an area or an outline at once, slow it down, or make a lane one-way.

    Vehicles inside leave, all others go round; bids and promises follow. Sent twice, it is one closure.
    `cut_off` names places that no vehicle can reach; ask `POST /api/closures/preview` first if that matters.
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
    """The effect that a closure would have, together with those in force. Nothing is closed."""
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
    """End a closure at once."""
    ended = await closings.open(closure)
    note.detail["closed_for"] = ended.reason
    return Json(ended)


def _row(request: ClosureRequest, plant: Plant, caller: Principal, now_s: float) -> ClosureRow:
    """The decision in a request.

    Raises:
        Problem: 422, with every invalid field.
    """
    request = request.model_copy(update={"lane": _driven(request.lane, plant)})
    faults = [*_extent_faults(request, plant), *_kind_faults(request, plant)]
    until_s = None if request.until is None else request.until.timestamp()
    if until_s is not None and until_s <= now_s:
        faults.append(FieldError.of("until", "passed"))
    elif until_s is not None and until_s > now_s + LONGEST_S:
        faults.append(FieldError.of("until", "more_than_a_year"))
    if faults:
        raise unusable(*faults)
    return ClosureRow(
        id="",
        kind=request.kind.value,
        start_node="" if request.lane is None else request.lane.start,
        end_node="" if request.lane is None else request.lane.end,
        place=request.place or "",
        area=request.area or "",
        outline=outline_of(_corners(request)) if request.outline else "",
        speed_mps=request.speed_mps,
        until_s=until_s,
        reason=request.reason,
        by=caller.name,
        person=f"{caller.kind}:{caller.id}",
        at_s=now_s,
    )


def _driven(lane: LaneRequest | None, plant: Plant) -> LaneRequest | None:
    """The lane meant: for a two-lane road named against one lane, the lane beside it."""
    if lane is None or plant.roads.lane(lane.start, lane.end) is not None:
        return lane
    start, end = plant.way_back(lane.end, lane.start)
    there, back = plant.roads.lane(lane.end, lane.start), plant.roads.lane(start, end)
    return lane if there is None or back is None else LaneRequest(start=start, end=end)


def _extent_faults(request: ClosureRequest, plant: Plant) -> list[FieldError]:
    lane, place, area = request.lane, request.place, request.area
    if sum(named is not None for named in (lane, place, area, request.outline)) != 1:
        return [FieldError("lane", "name exactly one of lane, place, area and outline")]
    if request.outline is not None:
        return _outline_faults(_corners(request), plant)
    if lane is not None and plant.roads.lane(lane.start, lane.end) is None:
        if plant.roads.lane(lane.end, lane.start) is not None:
            return [FieldError.of("lane", "lane_runs", start=lane.end, end=lane.start)]
        reason = f"no lane joins {lane.start} and {lane.end}; GET /api/plant has the lanes"
        return [FieldError("lane", reason)]
    if place is not None and not any(
        place in known for known in (plant.nodes, plant.crossings, plant.places)
    ):
        return [FieldError.of("place", "node_unknown", place=place)]
    if area is not None and area not in plant.areas:
        known = ", ".join(plant.areas) or "none"
        return [FieldError.of("area", "area_unknown", area=area, areas=known)]
    return []


def _corners(request: ClosureRequest) -> tuple[Corner, ...]:
    return tuple((round(corner.x_m, 2), round(corner.y_m, 2)) for corner in request.outline or ())


def _outline_faults(corners: tuple[Corner, ...], plant: Plant) -> list[FieldError]:
    faults = [
        FieldError.of(
            f"outline[{place}]", "off_the_floor", width=f"{plant.width_m:g}", depth=f"{plant.height_m:g}"
        )
        for place, (x_m, y_m) in enumerate(corners)
        if not (0.0 <= x_m <= plant.width_m and 0.0 <= y_m <= plant.height_m)
    ]
    if faults:
        return faults
    polygon = tuple(Point(x_m, y_m) for x_m, y_m in corners)
    if crossed_edges(polygon) is not None or area_m2(polygon) == 0.0:
        return [FieldError.of("outline", "edges_cross")]
    extent = plant.extent_within(corners)
    if not extent.nodes and not extent.across:
        return [FieldError.of("outline", "closes_nothing")]
    return []


def _kind_faults(request: ClosureRequest, plant: Plant) -> list[FieldError]:
    faults = []
    if request.kind is ClosureKind.SLOW and request.speed_mps is None:
        faults.append(FieldError.of("speed_mps", "slow_speed"))
    elif request.kind is not ClosureKind.SLOW and request.speed_mps is not None:
        faults.append(FieldError("speed_mps", "only what is slow has a speed"))
    if request.kind is ClosureKind.ONE_WAY:
        lane = request.lane
        if lane is None:
            faults.append(FieldError.of("lane", "one_way_lane"))
        elif (
            plant.roads.lane(lane.start, lane.end)
            and plant.roads.lane(*plant.way_back(lane.start, lane.end)) is None
        ):
            faults.append(FieldError.of("lane", "one_way_already"))
    return faults
