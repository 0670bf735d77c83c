"""Duty: people who can be asked for help, and their answers."""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import suppress
from math import inf
from typing import Annotated, Self

import msgspec
from fastapi import APIRouter, Depends
from pydantic import BaseModel, ConfigDict, Field, model_validator

from dray.body import CallPart
from dray.gateway.access.audit_log import Noted
from dray.gateway.access.caller import Caller
from dray.gateway.access.principal import Principal
from dray.gateway.factory.commands import Commands
from dray.gateway.factory.duty import DutyRota
from dray.gateway.http.problems import FieldError, Problem, unusable
from dray.gateway.http.provided import Provided
from dray.gateway.http.request_bodies import json_only
from dray.gateway.http.responses import Json, described, problems
from dray.gateway.live.projection import Projection
from dray.gateway.live.timescale import TimeScale
from dray.gateway.live.views.duty import CallView, ColleagueView, DutyChoice, DutyView
from dray.messages import (
    CallAnswer,
    CallState,
    CommandKind,
    HelpCall,
    MachineCommand,
    MachineCommandKind,
    ProblemKind,
)
from dray.messages.people.call import CALL_WAIT_MAX_S
from dray.plant import Plant
from dray.plant.people import people_of

router = APIRouter(tags=["factory"])

EXAMPLE = DutyView(
    state="on", code="k3x7m2qa", areas_without=("AREA3",), comes_at_s={"AREA3": 1_764_165_600.0}
)


class DutyRequest(BaseModel):
    """The caller's duty from now on."""

    model_config = ConfigDict(extra="forbid", json_schema_extra={"examples": [{"state": "on"}]})

    state: DutyChoice
    """`break`: present, but not to be asked."""
    busy_for_s: Annotated[float, Field(gt=0, le=86_400)] | None = None
    """Factory seconds for which the caller is busy."""
    helps_with: Annotated[list[ProblemKind], Field(max_length=len(ProblemKind))] = []
    """Kinds of problems; empty for all."""

    @model_validator(mode="after")
    def _only_who_is_on_duty_is_busy(self) -> Self:
        if self.busy_for_s is not None and self.state != "on":
            raise ValueError("busy_for_s is given with state on, and with no other")
        return self


class CallAnswerRequest(BaseModel):
    """The caller's answer to a call for help."""

    model_config = ConfigDict(
        extra="forbid", json_schema_extra={"examples": [{"answer": "take", "wait_s": 120}]}
    )

    answer: CallAnswer
    wait_s: Annotated[float, Field(gt=0, le=CALL_WAIT_MAX_S)] | None = None
    """With `take`: factory seconds until the help is done."""


class CallAnswered(msgspec.Struct, frozen=True):
    """The outcome of an answer."""

    expected: bool
    """Whether the caller is expected there; false if somebody else was quicker, or the answer was no."""


@router.get("/duty", responses={200: described(DutyView, "Duty", EXAMPLE)}, response_class=Json)
async def get_duty(
    rota: Provided[DutyRota], projection: Provided[Projection], time: Provided[TimeScale], caller: Caller
) -> Json:
    """Your duty, that of others, and calls for help.

    A panel asks every few seconds, which shows its presence.
    """
    return Json(_view(rota, projection, time, caller))


@router.put(
    "/duty",
    dependencies=[Depends(json_only)],
    responses={
        200: described(DutyView, "Duty", EXAMPLE),
        **problems(p409="Not a person", p503="No agents of operators run here"),
    },
    response_class=Json,
)
async def put_duty(
    rota: Provided[DutyRota],
    projection: Provided[Projection],
    time: Provided[TimeScale],
    caller: Caller,
    note: Noted,
    request: DutyRequest,
) -> Json:
    """Go on duty, have a break, or go off duty."""
    note.detail |= request.model_dump(mode="json", exclude_defaults=True)
    if request.state == "off":
        rota.go_off(caller)
    else:
        busy_s = request.busy_for_s
        rota.go_on(
            caller,
            on_break=request.state == "break",
            busy_until_s=None if busy_s is None else projection.plant_s(rota.wall_s()) + busy_s,
            helps_with=tuple(dict.fromkeys(request.helps_with)),
        )
    return Json(_view(rota, projection, time, caller))


@router.post(
    "/calls/{call}/answer",
    dependencies=[Depends(json_only)],
    responses={
        200: described(CallAnswered, "What has become of it", CallAnswered(expected=True)),
        **problems(p409="Not on duty, expected elsewhere, or nobody is asked any more"),
    },
    response_class=Json,
)
async def answer_call(
    rota: Provided[DutyRota],
    projection: Provided[Projection],
    commands: Provided[Commands],
    caller: Caller,
    note: Noted,
    call: str,
    request: CallAnswerRequest,
) -> Json:
    """Take a call for help, decline it, or say that you cannot.

    Taking the call also promises help to an agent whose work waits.
    """
    note.detail |= request.model_dump(mode="json", exclude_none=True)
    if request.answer is CallAnswer.TAKE and request.wait_s is None:
        raise unusable(FieldError("wait_s", "say within which time it will be done"))
    known = projection.people.call(call)
    is_open = known is not None and known.state is not CallState.ENDED and not known.taken_by
    seen = is_open and _sees(projection, caller, known)
    expected = await rota.answer(caller, call, request.answer, request.wait_s, is_open=seen)
    known = projection.people.call(call)
    if expected and known is not None and not known.goods and request.wait_s is not None:
        # A refused promise does not matter here: the call is taken anyway.
        with suppress(Problem):
            await _promise(projection, commands, caller, known.caller, request.wait_s)
    return Json(CallAnswered(expected=expected))


async def _promise(
    projection: Projection, commands: Commands, by: Principal, agent: str, wait_s: float
) -> None:
    """Promise help to a vehicle or machine whose work waits."""
    atv, machine = projection.atvs.last(agent), projection.machines.view(agent)
    if atv is not None and atv.help is not None:
        await commands.order(agent, CommandKind.PROMISE, by=by, wait_s=wait_s)
    elif machine is not None and machine.help is not None:
        said = MachineCommand(
            command=commands.new_name(), kind=MachineCommandKind.PROMISE, wait_s=wait_s, issued_by=by.name
        )
        await commands.give(agent, said, by=by)


def _sees(projection: Projection, by: Principal, call: HelpCall | None) -> bool:
    """Whether a caller sees the place of a call."""
    if call is None or by.areas is None:
        return call is not None
    return projection.site.plant.is_in(call.x_m, call.y_m, by.areas)


def _view(rota: DutyRota, projection: Projection, time: TimeScale, by: Principal) -> DutyView:
    now_s = projection.plant_s(rota.wall_s())
    known, people = rota.look(by), projection.people
    plant = projection.site.plant
    seen = set(plant.areas) if by.areas is None else set(by.areas)
    state: DutyChoice = "off" if known is None else "break" if known[1].state.on_break else "on"
    own = "" if known is None else known[0]
    # A person who has just gone off duty here is still heard for a moment.
    gone = rota.code_of(by.id) if own == "" and rota.has_said_off(by) else ""
    colleagues: list[ColleagueView] = []
    # The caller's own duty counts before it is heard.
    covered = (
        set() if known is None else set(plant.areas if known[1].state.everywhere else known[1].state.areas)
    )
    for each in people.on_duty(now_s):
        if each.operator == gone:
            continue
        areas = set(plant.areas) if each.everywhere else set(each.areas)
        covered |= areas
        if each.operator == own or not (each.everywhere or areas & seen or by.areas is None):
            continue
        colleagues.append(
            ColleagueView(
                code=_code(each.operator),
                label=each.label,
                areas=tuple(sorted(areas & seen)),
                station=each.station,
                status=each.status,
                busy_with=each.caller,
                until_at_s=None if each.until_s is None else time.to_wall_s(each.until_s),
                helps_with=each.helps_with,
            )
        )
    parts = {} if known is None else {shown.call.call: shown.part for shown in known[1].calls}
    calls: list[CallView] = []
    for call in people.calls(now_s):
        here, elsewhere = plant.areas_at(call.x_m, call.y_m), not _sees(projection, by, call)
        if call.call in parts or not elsewhere:
            area = plant.areas[here[0]].name if here else ""
            calls.append(_call(call, parts.get(call.call), area, time, elsewhere=elsewhere))
    tablet = None if known is None else known[1].state
    busy_s = None if tablet is None else tablet.busy_until_s
    return DutyView(
        state=state,
        code=_code(own),
        said_off=state == "off" and rota.has_said_off(by),
        helps_with=() if tablet is None else tablet.helps_with,
        busy_until_at_s=None if busy_s is None or busy_s <= now_s else time.to_wall_s(busy_s),
        colleagues=tuple(sorted(colleagues, key=lambda each: each.code)),
        areas_without=tuple(sorted(seen - covered)),
        comes_at_s=_comes_at_s(plant, sorted(seen - covered), now_s, time),
        calls=tuple(sorted(calls, key=lambda each: each.since_at_s)),
    )


def _comes_at_s(plant: Plant, areas: Iterable[str], now_s: float, time: TimeScale) -> dict[str, float]:
    """When people come to areas where nobody works now."""
    comes_s = {area: people_of(plant, area).next_on_s(now_s) for area in areas}
    return {area: time.to_wall_s(at_s) for area, at_s in comes_s.items() if now_s < at_s < inf}


def _call(call: HelpCall, part: CallPart | None, area: str, time: TimeScale, *, elsewhere: bool) -> CallView:
    left_s = None if call.until_s is None else max(0.0, call.until_s - call.at_s)
    return CallView(
        id=call.call,
        caller=call.caller,
        goods=call.goods,
        state=call.state,
        part=part,
        problem=call.problem.kind,
        needs_person=call.problem.needs_person,
        reason=call.reason,
        since_at_s=time.to_wall_s(call.since_s),
        until_at_s=None if left_s is None else time.to_wall_s(call.at_s + left_s),
        asked=tuple(_code(each) for each in call.asked),
        taken_by=_code(call.taken_by) if call.state is CallState.TAKEN else "",
        on_duty=call.on_duty,
        x_m=call.x_m,
        y_m=call.y_m,
        place=call.place,
        area=area,
        elsewhere=elsewhere,
    )


def _code(operator: str) -> str:
    return operator.partition(".")[2]
