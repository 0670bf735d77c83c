"""What people say has happened at a station whose body is people: a storage's, a source warehouse's, or the delivery gate."""

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
from dray.gateway.routes.factory.machine_commands import NAME, QUANTITY_MAX
from dray.gateway.routes.parameters import Visible
from dray.messages import MachineCommand, MachineCommandKind
from dray.messages.keys import GATE

router = APIRouter(tags=["factory"])


class StationCommandRequest(BaseModel):
    """A word to one station."""

    model_config = ConfigDict(
        extra="forbid",
        json_schema_extra={
            "examples": [
                {"kind": "arrived", "item": "shaft", "quantity": 12, "vehicle": "ATV3"},
                {"kind": "taken", "item": "shaft", "quantity": 12},
                {"kind": "arrived", "item": "order-7-1.1", "quantity": 4},
                {"kind": "stock_is", "item": "shaft", "quantity": 40, "sure": True},
            ]
        },
    )

    kind: Literal["arrived", "taken", "stock_is"]
    item: Annotated[str, Field(min_length=1, pattern=NAME)]
    """The material; at the gate, the goal that stands on the label."""
    quantity: Annotated[int, Field(strict=True, ge=0, le=QUANTITY_MAX)]
    """Pieces."""
    vehicle: Annotated[str, Field(pattern=NAME)] = ""
    """For `arrived` and `taken`: who has brought or fetched them; left out for by hand."""
    sure: bool = False
    """The number is right, however far it is from the expected one."""
    command: CommandName = None
    """A name for this word, by which the caller finds it in the stream. It is passed on again until the station has answered, and counts once."""

    @model_validator(mode="after")
    def _nobody_brings_a_count(self) -> Self:
        if self.vehicle and self.kind == "stock_is":
            raise ValueError("vehicle may be given with kind arrived and taken, and with no other")
        return self


@router.post(
    "/stations/{station}/commands",
    dependencies=[Depends(json_only)],
    responses={
        200: described(CommandAnswer, "The station's word", CommandAnswer("gateway.1-7", done=True)),
        **problems(
            p403="The station is not in the caller's areas",
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
    """Say what has arrived at a storage, a warehouse or the gate (station `gate`), was taken there, or lies there; waits for its word."""
    note.detail |= command.model_dump(mode="json", exclude_none=True)
    note.waits = True
    _area_rule(projection, caller, station)
    must_be_heard(projection, station, "The station is shut out", "; readmit it first")
    said = MachineCommand(
        command=command.command or commands.new_name(),
        kind=MachineCommandKind(command.kind),
        item=command.item,
        quantity=command.quantity,
        vehicle=command.vehicle,
        sure=command.sure,
        issued_by=caller.name,
    )
    answer = await commands.give(station, said, by=caller)
    return answered(answer, note, visible)


def _area_rule(projection: Projection, caller: Principal, station: str) -> None:
    """A caller who is limited to areas says what has happened there; of other stations not even that they are.

    Raises:
        Problem: 403, it stands elsewhere; 404, there is no such station, to a caller of the whole plant.
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
