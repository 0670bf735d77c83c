"""Drafts of plants: drawn beside the running one, checked, exported, and played before use."""

from __future__ import annotations

import base64
import binascii
import re
from http import HTTPStatus
from typing import Annotated

import msgspec
from fastapi import APIRouter, Body, Depends, Header, Path
from starlette.responses import Response

from dray.gateway.access.audit_log import Noted
from dray.gateway.access.caller import Caller
from dray.gateway.factory.dxf_plans import DxfPlans, NoPlan
from dray.gateway.factory.shift_player import PlayView, ShiftPlayer
from dray.gateway.http.problems import FieldError, Problem, not_found, unusable
from dray.gateway.http.provided import Now, Provided
from dray.gateway.http.renderings import Key, Renderings
from dray.gateway.http.request_bodies import json_only
from dray.gateway.http.responses import PAGE, Cursor, Json, Limit, described, list_of, page, problems
from dray.gateway.http.shares import share_of, share_used
from dray.gateway.http.side_work import SideWork
from dray.gateway.http.unread import Unread, UnreadRoute, read
from dray.gateway.http.versions import check_version, version_tag
from dray.gateway.live.projection import Projection
from dray.gateway.orders.order_ids import new_token
from dray.gateway.routes.factory.plant_draft_bodies import (
    EXAMPLE,
    PLAN_EXAMPLE,
    PLAY_EXAMPLE,
    ChangedDraft,
    DraftView,
    FloorPlan,
    NewDraft,
    PlanView,
    Shift,
)
from dray.gateway.routes.factory.plant_draft_work import (
    KeptDraft,
    changed_draft,
    draft_view,
    floor_plan,
    new_draft,
    plant_file,
    playable,
)
from dray.plant.model import PlantFile
from dray.store import Store
from dray.store.factory.plant_drafts import DraftLine, DraftRow

router = APIRouter(tags=["drafts"], route_class=UnreadRoute)

MAX_DRAFTS = 50
"""Maximum drafts of a plant; then one must be removed for a new one."""

LINE_EXAMPLE = DraftLine("line-4", "Line 4", 7, "Early shift", 1_893_456_000.0)

DXF = "image/vnd.dxf"

PLANS = {"image/png": b"\x89PNG\r\n\x1a\n", "image/svg+xml": b"", DXF: b""}
"""Floor plans by media type, and their first bytes."""

MAX_PLAN_BYTES = 700_000
"""Maximum bytes of a floor plan."""

SHOWN_ALONE = {"Content-Security-Policy": "default-src 'none'; style-src 'unsafe-inline'; sandbox"}
"""Headers that keep a plan opened by itself from doing anything."""

DraftId = Annotated[str, Path(max_length=64)]

IfMatch = Annotated[
    str | None, Header(alias="If-Match", description="The `ETag` of the version that is changed")
]

LISTED = "GET /api/plant-drafts"

TOO_MANY = {"p429": "Too many files of this caller are being read", "p503": "Too many files are being read"}


@router.get("/plant-drafts", responses={200: list_of(DraftLine, "All drafts, by id")}, response_class=Json)
async def list_drafts(store: Provided[Store], cursor: Cursor = None, limit: Limit = PAGE) -> Json:
    """The drafts of plants, without their content."""
    async with store.read() as work:
        drafts = await work.plant_drafts.all()
    return page(drafts, lambda draft: draft.id, cursor, limit)


@router.post(
    "/plant-drafts",
    status_code=HTTPStatus.CREATED,
    dependencies=[Depends(json_only)],
    responses={
        201: described(DraftView, "The draft", EXAMPLE),
        **problems(
            p409="There are too many drafts",
            p429="Too many drafts are this caller's, or too many of its files are being read",
            p503="Too many files are being read",
        ),
    },
    response_class=Json,
)
async def begin(
    store: Provided[Store],
    projection: Provided[Projection],
    side_work: Provided[SideWork],
    renderings: Provided[Renderings],
    caller: Caller,
    note: Noted,
    now_s: Now,
    body: Annotated[bytes, Body(), Unread(NewDraft)],
) -> Json:
    """Begin a draft from the running plant, or from a file in any format that `dray plant import` reads."""
    running = msgspec.json.encode(projection.site.plant.file)
    new = await side_work.do(caller.key, new_draft, body, running)
    note.detail |= {"name": new.name, "file_name": new.file_name}
    if new.fault is not None:
        raise unusable(new.fault)
    row = DraftRow(new_token()[:12], new.name, 1, caller.name, now_s, new.data, new.notes, owner=caller.key)
    view = await side_work.do(caller.key, draft_view, KeptDraft.of(row))
    async with store.write() as work:
        if await work.plant_drafts.count_of(caller.key) >= share_of(MAX_DRAFTS):
            raise share_used("drafts", MAX_DRAFTS, f"remove one of yours ({LISTED} lists them)")
        if await work.plant_drafts.count() >= MAX_DRAFTS:
            raise Problem(
                HTTPStatus.CONFLICT,
                "too-many-drafts",
                "There are too many drafts",
                f"{MAX_DRAFTS} are kept: remove one ({LISTED} lists them)",
            )
        await work.plant_drafts.put(row)
    renderings.keep(_view_key(row.id, row.version, row.plan_type), view)
    note.target = row.id
    return Json(
        view, HTTPStatus.CREATED, headers={"Location": f"/api/plant-drafts/{row.id}", "ETag": version_tag(1)}
    )


@router.get(
    "/plant-drafts/running",
    responses={200: described(PlantFile, "The running plant, as its file says it")},
    response_class=Json,
)
async def get_running(projection: Provided[Projection]) -> Json:
    """The plant file of the running plant, on which drafts are based.

    `GET /api/plant` has its floor as driven.
    """
    return Json(projection.site.plant.file)


@router.get(
    "/plant-drafts/{draft}",
    responses={
        200: described(DraftView, "The draft", EXAMPLE),
        **problems(p404="There is no such draft", **TOO_MANY),
    },
    response_class=Json,
)
async def get_draft(
    store: Provided[Store], renderings: Provided[Renderings], caller: Caller, draft: DraftId
) -> Json:
    """A draft with its content, faults and warnings."""
    version, plan_type = await _state(store, draft)
    view = renderings.get(_view_key(draft, version, plan_type))
    if view is None:
        row = await _row(store, draft)
        version, key = row.version, _view_key(draft, row.version, row.plan_type)
        view = await renderings.of(key, caller.key, draft_view, KeptDraft.of(row))
    return Json(view, headers={"ETag": version_tag(version)})


@router.put(
    "/plant-drafts/{draft}",
    dependencies=[Depends(json_only)],
    responses={
        200: described(DraftView, "The draft as it is now", EXAMPLE),
        **problems(
            p404="There is no such draft",
            p412="Somebody has changed it since",
            p428="It is not said which version is changed",
            **TOO_MANY,
        ),
    },
    response_class=Json,
)
async def change(
    store: Provided[Store],
    side_work: Provided[SideWork],
    renderings: Provided[Renderings],
    caller: Caller,
    note: Noted,
    now_s: Now,
    draft: DraftId,
    body: Annotated[bytes, Body(), Unread(ChangedDraft)],
    if_match: IfMatch = None,
) -> Json:
    """Store a changed draft.

    `If-Match` names the version it is based on, so that nobody's work is overwritten unseen.
    """
    changed = await side_work.do(caller.key, changed_draft, body)
    note.target, note.detail["name"] = draft, changed.name
    if changed.fault is not None:
        raise unusable(changed.fault)
    before = await _row(store, draft)
    check_version(before.version, if_match, _changed(before))
    row = msgspec.structs.replace(
        before,
        name=changed.name,
        version=before.version + 1,
        data=changed.data,
        by=caller.name,
        at_s=now_s,
    )
    # Judged before it is stored: a draft too slow to judge could not be shown either.
    view = await side_work.do(caller.key, draft_view, KeptDraft.of(row))
    async with store.write() as work:
        if not await work.plant_drafts.change(row):
            raise _changed(before)
    renderings.keep(_view_key(row.id, row.version, row.plan_type), view)
    return Json(view, headers={"ETag": version_tag(row.version)})


@router.delete(
    "/plant-drafts/{draft}",
    status_code=HTTPStatus.NO_CONTENT,
    responses={**problems(p404="There is no such draft")},
    response_class=Response,
)
async def remove(store: Provided[Store], note: Noted, draft: DraftId) -> Response:
    """Remove a draft with its floor plan. The running plant is unchanged."""
    note.target = draft
    async with store.write() as work:
        if not await work.plant_drafts.remove(draft):
            raise not_found("draft", draft, LISTED)
    return Response(status_code=HTTPStatus.NO_CONTENT)


@router.get(
    "/plant-drafts/{draft}/file",
    responses={
        200: {
            "description": "The plant file",
            "content": {"application/yaml": {"schema": {"type": "object"}}},
        },
        **problems(p404="There is no such draft", **TOO_MANY),
    },
    response_class=Response,
)
async def get_file(
    store: Provided[Store], renderings: Provided[Renderings], caller: Caller, draft: DraftId
) -> Response:
    """The draft's plant file (YAML) without closed lanes, for `dray plant check` and `dray up --plant`."""
    version, _ = await _state(store, draft)
    file = renderings.get(_file_key(draft, version))
    if file is None:
        row = await _row(store, draft)
        file = await renderings.of(_file_key(draft, row.version), caller.key, plant_file, row.data)
    return Response(
        file,
        media_type="application/yaml",
        headers={"Content-Disposition": f'attachment; filename="{_plant_id(file) or draft}.yaml"'},
    )


@router.put(
    "/plant-drafts/{draft}/plan",
    dependencies=[Depends(json_only)],
    responses={
        200: described(PlanView, "It lies under the draft", PLAN_EXAMPLE),
        **problems(p404="There is no such draft", **TOO_MANY),
    },
    response_class=Json,
)
async def put_plan(
    store: Provided[Store],
    plans: Provided[DxfPlans],
    side_work: Provided[SideWork],
    caller: Caller,
    note: Noted,
    draft: DraftId,
    body: Annotated[bytes, Body(), Unread(FloorPlan)],
) -> Json:
    """Lay a floor plan under a draft: PNG, SVG or DXF, which becomes SVG.

    Its position is in the draft's `plan`.
    """
    request = await side_work.do(caller.key, floor_plan, body)
    note.target = draft
    if request.media_type not in PLANS:
        raise unusable(FieldError("media_type", f"is none of {', '.join(PLANS)}"))
    note.detail["media_type"] = request.media_type
    try:
        content = base64.b64decode(request.base64, validate=True)
    except (binascii.Error, ValueError):
        raise unusable(FieldError("base64", "is no base64")) from None
    if not content.startswith(PLANS[request.media_type]):
        raise unusable(FieldError("base64", f"is no {request.media_type}"))
    view = PlanView(media_type=request.media_type)
    if request.media_type == DXF:
        await _row(store, draft)
        try:
            picture = await plans.picture(content)
        except NoPlan as error:
            raise unusable(FieldError("base64", str(error))) from None
        content = picture.svg
        view = PlanView(
            media_type="image/svg+xml",
            width_m=picture.width_m,
            height_m=picture.height_m,
            notes=picture.notes,
        )
    if len(content) > MAX_PLAN_BYTES:
        raise unusable(FieldError("base64", f"is more than {MAX_PLAN_BYTES} bytes: make the picture smaller"))
    async with store.write() as work:
        if not await work.plant_drafts.put_plan(draft, view.media_type, content):
            raise not_found("draft", draft, LISTED)
    return Json(view)


@router.get(
    "/plant-drafts/{draft}/plan",
    responses={
        200: {"description": "The picture", "content": {"image/png": {}, "image/svg+xml": {}}},
        **problems(p404="There is no such draft, or it has no floor plan"),
    },
    response_class=Response,
)
async def get_plan(store: Provided[Store], draft: DraftId) -> Response:
    """The floor plan under a draft."""
    async with store.read() as work:
        found = await work.plant_drafts.plan(draft)
    if found is None:
        await _state(store, draft)
        raise Problem(
            HTTPStatus.NOT_FOUND,
            "unknown-plan",
            "The draft has no floor plan",
            f"nothing lies under draft {draft}; PUT /api/plant-drafts/{draft}/plan lays a picture there",
        )
    return Response(found[1], media_type=found[0], headers=SHOWN_ALONE)


@router.post(
    "/plant-drafts/{draft}/play",
    status_code=HTTPStatus.ACCEPTED,
    dependencies=[Depends(json_only)],
    responses={
        202: described(PlayView, "It is being played", PLAY_EXAMPLE),
        **problems(p404="There is no such draft", p409="Another shift is being played", **TOO_MANY),
    },
    response_class=Json,
)
async def play(
    store: Provided[Store],
    side_work: Provided[SideWork],
    player: Provided[ShiftPlayer],
    caller: Caller,
    note: Noted,
    draft: DraftId,
    body: Annotated[bytes, Body(), Unread(Shift)],
) -> Json:
    """Play a shift in the draft and in the running plant, in a bounded simulator process.

    A draft with faults cannot be played. `GET` on the same address has the progress.
    """
    request = read(Shift, body)
    note.target = draft
    row = await _row(store, draft)
    text = await side_work.do(caller.key, playable, row.data)
    return Json(player.play(draft, text, row.version, request.hours, request.seed), HTTPStatus.ACCEPTED)


@router.get(
    "/plant-drafts/{draft}/play",
    responses={200: described(PlayView, "The newest shift of the draft", PLAY_EXAMPLE)},
    response_class=Json,
)
async def get_play(player: Provided[ShiftPlayer], draft: DraftId) -> Json:
    """The result of the last shift played, with the version of its draft."""
    return Json(player.result(draft))


def _view_key(draft: str, version: int, plan_type: str) -> Key:
    """The key of a draft's answer. A floor plan is laid without a new version."""
    return ("draft", draft, version, plan_type)


def _file_key(draft: str, version: int) -> Key:
    return ("plant file", draft, version)


def _plant_id(file: bytes) -> str:
    """The id of the plant in a plant file; empty if it is none for the name of a file."""
    found = re.search(rb"^plant: ([A-Za-z][A-Za-z0-9_.-]{0,31})\r?$", file, re.MULTILINE)
    return found[1].decode() if found else ""


async def _state(store: Store, draft: str) -> tuple[int, str]:
    """Version and floor plan's media type."""
    async with store.read() as work:
        state = await work.plant_drafts.state(draft)
    if state is None:
        raise not_found("draft", draft, LISTED)
    return state


async def _row(store: Store, draft: str) -> DraftRow:
    async with store.read() as work:
        row = await work.plant_drafts.get(draft)
    if row is None:
        raise not_found("draft", draft, LISTED)
    return row


def _changed(row: DraftRow) -> Problem:
    return Problem(
        HTTPStatus.PRECONDITION_FAILED,
        "draft-changed",
        "Somebody has changed the draft since",
        f"{row.by} has saved version {row.version}: read it, and draw your change on that",
    )
