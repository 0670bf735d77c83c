"""People's reports to stations: events where people are its body (a storage, a source warehouse or the gate).

Also decisions about a thing on board of a failed vehicle.
"""

from __future__ import annotations

from typing import Annotated, Literal, Self

from fastapi import APIRouter, Depends
from pydantic import BaseModel, ConfigDict, Field, model_validator

from dray.gateway.access.audit_log import Noted
from dray.gateway.access.caller import Caller
from dray.gateway.access.gate import forbidden
from dray.gateway.access.principal import Principal
from dray.gateway.factory.commands import Commands
from dray.gateway.http.problems import not_found
from dray.gateway.http.provided import Provided
from dray.gateway.http.request_bodies import json_only
from dray.gateway.http.responses import Json, described, problems
from dray.gateway.live.places import areas_of
from dray.gateway.live.projection import Projection
from dray.gateway.routes.factory.command_answers import CommandAnswer, CommandName, answered, must_be_heard
from dray.gateway.routes.factory.machine_commands import (
    NAME,
    QUANTITY_MAX,
    areas_near,
    goods_m,
    named,
)
from dray.gateway.routes.parameters import Visible
from dray.messages import MachineCommand, MachineCommandKind
from dray.messages.keys import GATE

router = APIRouter(tags=["factory"])


class StationCommandRequest(BaseModel):
    """A report to one station."""

    model_config = ConfigDict(
        extra="forbid",
        json_schema_extra={
            "examples": [
                {"kind": "arrived", "item": "shaft", "quantity": 12, "vehicle": "ATV3"},
                {"kind": "taken", "item": "shaft", "quantity": 12},
                {"kind": "arrived", "item": "order-7-1.1", "quantity": 4},
                {"kind": "stock_is", "item": "shaft", "quantity": 40, "sure": True},
                {"kind": "fetch_goods", "task": "T-1M9K3X2A4-K7QM-1", "node": "c2"},
                {"kind": "write_off", "task": "T-1M9K3X2A4-K7QM-1"},
            ]
        },
    )

    kind: Literal["arrived", "taken", "stock_is", "fetch_goods", "write_off", "load_there", "load_missing"]
    item: Annotated[str, Field(pattern=NAME)] = ""
    """For `arrived`, `taken` and `stock_is`: the material; at the gate, the goal on the label."""
    quantity: Annotated[int | None, Field(strict=True, ge=0, le=QUANTITY_MAX)] = None
    """For `arrived`, `taken` and `stock_is`: pieces."""
    vehicle: Annotated[str, Field(pattern=NAME)] = ""
    """For `arrived` and `taken`: the vehicle; left out if moved by hand."""
    task: Annotated[str, Field(max_length=64)] = ""
    """For `fetch_goods` and `write_off`: the transport whose thing is on board of a failed vehicle. For `load_there`
    and `load_missing`: the name of a doubtful load (`doubts`) that somebody has counted."""
    node: Annotated[str, Field(max_length=64)] = ""
    """For `fetch_goods` only: node where a person hands it over; left out for the nearest node beside the
    vehicle."""
    sure: bool = False
    """Confirms a number far from the expected one."""
    command: CommandName = None
    """The caller's name for this report, to find it in the stream. It is passed on again until the station
    has answered, and counts once."""

    @model_validator(mode="after")
    def _nobody_brings_a_count(self) -> Self:
        if self.vehicle and self.kind == "stock_is":
            raise ValueError("vehicle may be given with kind arrived and taken, and with no other")
        return self

    @model_validator(mode="after")
    def _fields_belong_to_their_kinds(self) -> Self:
        is_word = MachineCommandKind(self.kind).is_word
        if is_word != (bool(self.item) and self.quantity is not None):
            raise ValueError(
                "item and quantity are given with arrived, taken and stock_is, and with no other"
            )
        if is_word == bool(self.task):
            kinds = "fetch_goods, write_off, load_there or load_missing"
            raise ValueError(f"task is given with kind {kinds}, and with no other")
        if self.node and self.kind != "fetch_goods":
            raise ValueError("node may be given with kind fetch_goods, and with no other")
        if not is_word and (self.item or self.quantity is not None or self.vehicle or self.sure):
            raise ValueError("item, quantity, vehicle and sure are given with words, and with no other")
        return self


@router.post(
    "/stations/{station}/commands",
    dependencies=[Depends(json_only)],
    responses={
        200: described(CommandAnswer, "The station's word", CommandAnswer("gateway.1-7", done=True)),
        **problems(
            p403="The station, or the thing that it is about, is not in the caller's areas",
            p404="There is no such station",
            p409="The name of the command was used for another one, or the station is shut out",
            p503="Too many commands wait for an answer",
            p504="The station has not confirmed in time",
        ),
    },
    response_class=Json,
)
async def command_station(
    commands: Provided[Commands],
    projection: Provided[Projection],
    caller: Caller,
    visible: Visible,
    note: Noted,
    station: str,
    command: StationCommandRequest,
) -> Json:
    """Report to a station (the gate is `gate`), and wait for its answer.

    Reports: arrivals, withdrawals, stock, whether a doubtful load is there, or a decision about a thing on board of
    a failed vehicle.
    """
    note.detail |= command.model_dump(mode="json", exclude_none=True)
    note.waits = True
    kind = MachineCommandKind(command.kind)
    place_m = goods_m(projection, station, kind, command.task)
    if place_m is None:
        _area_rule(projection, caller, station)
    elif caller.areas is not None and caller.areas.isdisjoint(areas_near(projection, *place_m)):
        raise forbidden(f"what {command.task} carries is not in your areas ({named(caller.areas)})")
    must_be_heard(projection, station, "The station is shut out", "; readmit it first")
    said = MachineCommand(
        command=command.command or commands.new_name(),
        kind=kind,
        item=command.item,
        quantity=command.quantity or 0,
        task=command.task,
        node=command.node,
        vehicle=command.vehicle,
        sure=command.sure,
        issued_by=caller.name,
    )
    answer = await commands.give(station, said, by=caller)
    return answered(answer, note, visible)


def _area_rule(projection: Projection, caller: Principal, station: str) -> None:
    """A caller limited to areas reports only on stations there, and does not learn whether others exist.

    Raises:
        Problem: 403, it stands elsewhere; 404, no such station, for a whole-plant caller.
    """
    plant = projection.site.plant
    is_station = station == GATE or station in plant.stores
    if caller.areas is None:
        if not is_station:
            raise not_found("station", station, "GET /api/storages")
        return
    if not is_station or caller.areas.isdisjoint(areas_of(plant, station)):
        areas = ", ".join(sorted(caller.areas)) or "none"
        raise forbidden(f"{station} is not in your areas ({areas})")
