"""People's commands to machines (paper, case 1)."""

from __future__ import annotations

from typing import Annotated, Self

from fastapi import APIRouter, Depends
from pydantic import BaseModel, ConfigDict, Field, model_validator

from dray.gateway.access.audit_log import Noted
from dray.gateway.access.caller import Caller
from dray.gateway.access.gate import forbidden
from dray.gateway.access.principal import Principal
from dray.gateway.factory.commands import Commands
from dray.gateway.http.problems import not_found
from dray.gateway.http.provided import Provided
from dray.gateway.http.request_bodies import NOTE, json_only
from dray.gateway.http.responses import Json, described, problems
from dray.gateway.live.projection import Projection
from dray.gateway.routes.factory.command_answers import CommandAnswer, CommandName, answered, must_be_heard
from dray.gateway.routes.parameters import Visible
from dray.messages import MachineCommand, MachineCommandKind
from dray.messages.people.command import OUT_MAX_S, PROMISE_MAX_S

router = APIRouter(tags=["factory"])

NAME = r"^[A-Za-z0-9._-]{0,64}$"

QUANTITY_MAX = 1_000_000
"""Maximum pieces in one report: more than a place holds."""


class MachineCommandRequest(BaseModel):
    """A command to one machine."""

    model_config = ConfigDict(
        extra="forbid",
        json_schema_extra={
            "examples": [
                {"kind": "promise", "wait_s": 120.0},
                {"kind": "clear_fault"},
                {"kind": "hand_over"},
                {"kind": "set_speed", "speed_frac": 0.5},
                {"kind": "restart"},
                {"kind": "take_out", "reason": "new bearings", "wait_s": 3600.0, "after_work": True},
                {"kind": "put_in"},
                {"kind": "fetch_goods", "task": "M3-12", "node": "c2"},
                {"kind": "write_off", "task": "M3-12"},
                {"kind": "load_missing", "task": "M3-13"},
                {"kind": "arrived", "item": "shaft", "quantity": 12, "vehicle": "ATV3"},
                {"kind": "made", "quantity": 1},
                {"kind": "stock_is", "item": "shaft", "quantity": 40, "sure": True},
            ]
        },
    )

    kind: MachineCommandKind
    speed_frac: Annotated[float | None, Field(strict=True, gt=0, le=1)] = None
    """For `set_speed` only: fraction of the machine's own speed."""
    wait_s: Annotated[float | None, Field(strict=True, gt=0, le=OUT_MAX_S)] = None
    """For `promise`: factory seconds until the help is done, 900 at most. For `take_out`: expected factory
    seconds out of service; left out if unknown."""
    reason: Annotated[str, Field(max_length=200, pattern=NOTE)] = ""
    """For `take_out` only: the reason."""
    after_work: bool = False
    """For `take_out` only: whether it first finishes its present goal."""
    task: Annotated[str, Field(max_length=64)] = ""
    """For `fetch_goods` and `write_off`: the transport whose goods are on board of a failed vehicle. For
    `load_there` and `load_missing`: the transport held until somebody looks for its load (`POST
    /api/tasks/{task}/load` finds the machine by itself), or the name of a doubtful load (`doubts`) that somebody has
    counted."""
    node: Annotated[str, Field(max_length=64)] = ""
    """For `fetch_goods` only: node where a person hands them over; left out for the nearest node beside the
    vehicle."""
    item: Annotated[str, Field(pattern=NAME)] = ""
    """For words (`arrived`, `taken`, `made`, `scrapped` and `stock_is`, to a machine whose body is people):
    the material or product. Optional with `made` and `scrapped`, which then mean the product being made."""
    quantity: Annotated[int | None, Field(strict=True, ge=0, le=QUANTITY_MAX)] = None
    """For words: pieces."""
    vehicle: Annotated[str, Field(pattern=NAME)] = ""
    """For `arrived` and `taken`: the vehicle; left out if moved by hand."""
    sure: bool = False
    """For words: confirms a number far from the expected one."""
    command: CommandName = None
    """The caller's name for this command, to find it in the stream. A repeated command of the same name is
    not executed again. A word is passed on again until the machine has answered, and counts once."""

    @model_validator(mode="after")
    def _numbers_belong_to_their_kinds(self) -> Self:
        if (self.speed_frac is not None) != (self.kind is MachineCommandKind.SET_SPEED):
            raise ValueError("speed_frac is given with kind set_speed, and with no other")
        out = self.kind is MachineCommandKind.TAKE_OUT
        if (self.wait_s is not None) != (self.kind is MachineCommandKind.PROMISE) and not out:
            raise ValueError("wait_s is given with kind promise, and may be with take_out, and with no other")
        if not out and (self.wait_s or 0.0) > PROMISE_MAX_S:
            raise ValueError(f"a promise is for {PROMISE_MAX_S:g} s at most")
        if not out and (self.reason or self.after_work):
            raise ValueError("reason and after_work are given with kind take_out, and with no other")
        if bool(self.task) != self.kind.names_task:
            kinds = "fetch_goods, write_off, load_there or load_missing"
            raise ValueError(f"task is given with kind {kinds}, and with no other")
        if self.node and self.kind is not MachineCommandKind.FETCH_GOODS:
            raise ValueError("node may be given with kind fetch_goods, and with no other")
        self._words_are_whole()
        return self

    def _words_are_whole(self) -> None:
        kind, is_word = self.kind, self.kind.is_word
        if (self.quantity is not None) != is_word:
            raise ValueError("quantity is given with words (arrived, taken, made, scrapped, stock_is) only")
        if not is_word and (self.item or self.sure):
            raise ValueError("item and sure are given with words, and with no other")
        makes = kind in (MachineCommandKind.MADE, MachineCommandKind.SCRAPPED)
        if is_word and not makes and not self.item:
            raise ValueError(f"item is given with kind {kind.value}")
        if self.vehicle and kind not in (MachineCommandKind.ARRIVED, MachineCommandKind.TAKEN):
            raise ValueError("vehicle may be given with kind arrived and taken, and with no other")


@router.post(
    "/machines/{machine}/commands",
    dependencies=[Depends(json_only)],
    responses={
        200: described(CommandAnswer, "The machine's word", CommandAnswer("gateway.1-7", done=True)),
        **problems(
            p403="The machine, or the goods that it is about, are not in the caller's areas",
            p404="There is no such machine",
            p409="The name of the command was used for another one, or the machine is shut out",
            p503="Too many commands wait for an answer",
            p504="The machine has not confirmed in time",
        ),
    },
    response_class=Json,
)
async def command_machine(
    commands: Provided[Commands],
    projection: Provided[Projection],
    caller: Caller,
    visible: Visible,
    note: Noted,
    machine: str,
    command: MachineCommandRequest,
) -> Json:
    """Command a machine or report to it, and wait for its answer.

    Commands: promise help, clear a fault, hand goals over, slow down, restart, take it out of service or
    back, fetch goods, write them off, or report what has happened.
    """
    note.detail |= command.model_dump(mode="json", exclude_none=True)
    note.waits = True
    place_m = goods_m(projection, machine, command.kind, command.task)
    if place_m is None:
        _area_rule(projection, caller, machine)
    elif caller.areas is not None and caller.areas.isdisjoint(areas_near(projection, *place_m)):
        raise forbidden(f"the goods of {command.task} are not in your areas ({named(caller.areas)})")
    must_be_heard(projection, machine, "The machine is shut out", "; readmit it first")
    said = MachineCommand(
        command=command.command or commands.new_name(),
        kind=command.kind,
        speed_frac=command.speed_frac,
        wait_s=command.wait_s,
        reason=command.reason,
        after_work=command.after_work,
        task=command.task,
        node=command.node,
        item=command.item,
        quantity=command.quantity or 0,
        vehicle=command.vehicle,
        sure=command.sure,
        issued_by=caller.name,
    )
    answer = await commands.give(machine, said, by=caller)
    return answered(answer, note, visible)


def goods_m(
    projection: Projection, place: str, kind: MachineCommandKind, task: str
) -> tuple[float, float] | None:
    """The position of the goods or thing that a command is about; None if unknown.

    Only people responsible for that place may give the command.
    """
    view = projection.tasks.view(task) if kind.is_about_goods else None
    if view is None or view.coordinator != place or view.stranded is None:
        return None
    spot = projection.site.plant.nodes.get(view.stranded.node)
    return None if spot is None else (spot.x_m, spot.y_m)


def areas_near(projection: Projection, x_m: float, y_m: float) -> frozenset[str]:
    """The areas around a point (m)."""
    return frozenset(projection.site.plant.areas_near(x_m, y_m, 0.0))


def named(areas: frozenset[str]) -> str:
    """Names of areas as text."""
    return ", ".join(sorted(areas)) or "none"


def _area_rule(projection: Projection, caller: Principal, machine: str) -> None:
    """A caller limited to areas commands only machines there, and does not learn whether others exist.

    Raises:
        Problem: 403, it stands elsewhere; 404, no such machine, for a whole-plant caller.
    """
    plant = projection.site.plant
    if caller.areas is None:
        if projection.machines.view(machine) is None:
            raise not_found("machine", machine, "GET /api/machines")
        return
    here = machine in plant.machines
    near = areas_near(projection, *plant.position_of(machine)) if here else frozenset[str]()
    if caller.areas.isdisjoint(near):
        raise forbidden(f"{machine} is not in your areas ({named(caller.areas)})")
