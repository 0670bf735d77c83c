"""ATVs: their state, and people's commands to them."""

from __future__ import annotations

from typing import Annotated, Self

from fastapi import APIRouter, Depends, Response
from pydantic import BaseModel, ConfigDict, Field, ValidationInfo, field_validator, model_validator

from dray.gateway.access.audit_log import Noted
from dray.gateway.access.caller import Caller
from dray.gateway.access.gate import forbidden, missing
from dray.gateway.access.principal import Principal, Scope
from dray.gateway.factory.commands import Commands
from dray.gateway.http.csv_tables import Format, header_of, row_of, table, with_csv
from dray.gateway.http.problems import not_found
from dray.gateway.http.provided import Provided
from dray.gateway.http.request_bodies import NOTE, json_only
from dray.gateway.http.responses import PAGE, Cursor, Json, Limit, described, list_of, page, problems
from dray.gateway.live.projection import Projection
from dray.gateway.live.views import AtvView
from dray.gateway.routes.factory.command_answers import CommandAnswer, CommandName, answered, must_be_heard
from dray.gateway.routes.parameters import Visible
from dray.messages import CommandKind
from dray.messages.people.command import OUT_MAX_S, PROMISE_MAX_S

router = APIRouter(tags=["factory"])


COLUMNS = (
    *("id", "type", "status", "problem", "battery_frac", "load", "load_quantity", "link"),
    *("node", "x_m", "y_m", "speed_mps", "speed_limit_frac", "dwell_point", "software", "seen_at_s"),
)


class CommandRequest(BaseModel):
    """A command to one vehicle."""

    model_config = ConfigDict(
        extra="forbid",
        json_schema_extra={
            "examples": [
                {"kind": "stop"},
                {"kind": "set_speed", "speed_frac": 0.5},
                {"kind": "promise", "wait_s": 120.0},
                {"kind": "hand_over"},
                {"kind": "charge"},
                {"kind": "take_out", "reason": "brakes", "wait_s": 3600.0, "after_work": True},
                {"kind": "put_in"},
            ]
        },
    )

    kind: CommandKind
    speed_frac: Annotated[float | None, Field(strict=True, gt=0, le=1)] = None
    """For `set_speed` only: fraction of the vehicle's own top speed."""
    wait_s: Annotated[float | None, Field(strict=True, gt=0, le=OUT_MAX_S)] = None
    """For `promise`: factory seconds until the help is done, 900 at most. For `take_out`: expected factory
    seconds out of service; left out if unknown."""
    reason: Annotated[str, Field(max_length=200, pattern=NOTE)] = ""
    """For `take_out` only: the reason."""
    after_work: bool = False
    """For `take_out` only: whether it first finishes what it carries."""
    command: CommandName = None
    """The caller's name for this command, to find it in the stream. A repeated command of the same name is
    not executed again."""

    @field_validator("wait_s")
    @classmethod
    def _a_promise_is_short(cls, wait_s: float | None, info: ValidationInfo) -> float | None:
        if wait_s is not None and wait_s > PROMISE_MAX_S and info.data.get("kind") is CommandKind.PROMISE:
            raise ValueError(f"a promise is for {PROMISE_MAX_S:g} s at most")
        return wait_s

    @model_validator(mode="after")
    def _numbers_belong_to_their_kinds(self) -> Self:
        if (self.speed_frac is not None) != (self.kind is CommandKind.SET_SPEED):
            raise ValueError("speed_frac is given with kind set_speed, and with no other")
        out = self.kind is CommandKind.TAKE_OUT
        if (self.wait_s is not None) != (self.kind is CommandKind.PROMISE) and not out:
            raise ValueError("wait_s is given with kind promise, and may be with take_out, and with no other")
        if not out and (self.reason or self.after_work):
            raise ValueError("reason and after_work are given with kind take_out, and with no other")
        return self


@router.get("/atvs", responses={200: with_csv(list_of(AtvView, "ATVs, by id"))}, response_class=Json)
async def list_atvs(
    projection: Provided[Projection],
    visible: Visible,
    cursor: Cursor = None,
    limit: Limit = PAGE,
    format: Format = "json",  # noqa: A002 - the word that others use
) -> Response:
    """ATVs that have been heard."""
    atvs = [view for each in projection.atvs.views() if (view := visible.atv(each))]
    if format == "csv":
        return table("fleet", header_of(COLUMNS), (row_of(COLUMNS, atv) for atv in atvs))
    return page(atvs, lambda atv: atv.id, cursor, limit)


@router.get(
    "/atvs/{atv}",
    responses={200: described(AtvView, "The ATV"), **problems(p404="There is no such ATV")},
    response_class=Json,
)
async def get_atv(projection: Provided[Projection], visible: Visible, atv: str) -> Json:
    """One ATV."""
    whole = projection.atvs.view(atv)
    view = whole and visible.atv(whole)
    if view is None:
        raise not_found("atv", atv, "GET /api/atvs")
    return Json(view)


@router.post(
    "/atvs/{atv}/commands",
    dependencies=[Depends(json_only)],
    responses={
        200: described(CommandAnswer, "The vehicle's word", CommandAnswer("gateway.1-7", done=True)),
        **problems(
            p403="The vehicle is not shown in the caller's areas; a stop is passed on to it all the same",
            p404="There is no such ATV",
            p409="The name of the command was used for another one, or the vehicle is shut out",
            p503="Too many commands wait for an answer",
            p504="The vehicle has not confirmed in time",
        ),
    },
    response_class=Json,
)
async def command_atv(
    commands: Provided[Commands],
    projection: Provided[Projection],
    caller: Caller,
    visible: Visible,
    note: Noted,
    atv: str,
    command: CommandRequest,
) -> Json:
    """Command a vehicle, and wait for its answer.

    Commands: stop, acknowledge, resume, limit the speed, promise help, hand the task over, charge, take it
    out of service or back.
    """
    note.detail |= command.model_dump(mode="json", exclude_none=True)
    note.waits = command.kind is not CommandKind.STOP
    if command.kind is not CommandKind.STOP and not caller.may(Scope.VEHICLES_COMMAND):
        raise missing(caller, Scope.VEHICLES_COMMAND)
    area_rule(projection, caller, atv, command.kind)
    if command.kind is not CommandKind.STOP:
        must_be_heard(
            projection,
            atv,
            "The vehicle is shut out",
            ": it can be stopped, and nothing else; readmit it first",
        )
    try:
        answer = await commands.order(
            atv,
            command.kind,
            by=caller,
            command=command.command,
            speed_frac=command.speed_frac,
            wait_s=command.wait_s,
            reason=command.reason,
            after_work=command.after_work,
        )
    finally:
        note.elsewhere = commands.went_beside(command.command)
    return answered(answer, note, visible)


def area_rule(projection: Projection, caller: Principal, atv: str, kind: CommandKind) -> None:
    """A caller limited to areas commands only vehicles there, and does not learn whether others exist.

    A stop goes to a vehicle wherever it is shown: the picture may be old or forged, and a vehicle that drives
    on is worse than one whose existence is revealed. The grant names the caller's areas only, and the
    vehicle, which knows its position, refuses it elsewhere.

    Raises:
        Problem: 403, it is shown elsewhere, or the caller has no area; 404, no such vehicle, for a
            whole-plant caller or a stop.
    """
    if caller.areas is None or (caller.areas and kind is CommandKind.STOP):
        if atv not in projection.atvs:
            raise not_found("atv", atv, "GET /api/atvs")
        return
    place_m = projection.atvs.place_m(atv)
    near = () if place_m is None else projection.site.plant.areas_near(*place_m, kind.margin_m)
    if caller.areas.isdisjoint(near):
        areas = ", ".join(sorted(caller.areas)) or "none"
        raise forbidden(f"{atv} is not in your areas ({areas})")
