"""A person's report on a load that is perhaps there but not counted."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Depends
from pydantic import BaseModel, ConfigDict, Field

from dray.gateway.access.audit_log import Noted
from dray.gateway.access.caller import Caller
from dray.gateway.access.gate import forbidden
from dray.gateway.access.principal import Principal
from dray.gateway.factory.commands import Commands
from dray.gateway.http.problems import not_found
from dray.gateway.http.provided import Provided
from dray.gateway.http.request_bodies import json_only
from dray.gateway.http.responses import Json, described, problems
from dray.gateway.live.projection import Projection
from dray.gateway.live.views import TaskView
from dray.gateway.routes.factory.command_answers import CommandAnswer, CommandName, answered, must_be_heard
from dray.gateway.routes.parameters import Visible
from dray.messages import MachineCommand, MachineCommandKind

router = APIRouter(tags=["factory"])


class LoadSeenRequest(BaseModel):
    """The report of a person who has looked."""

    model_config = ConfigDict(
        extra="forbid", json_schema_extra={"examples": [{"there": False}, {"there": True}]}
    )

    there: Annotated[bool, Field(strict=True)]
    """Whether the load is at its destination."""
    command: CommandName = None
    """The caller's name for this report, to find it in the stream. A repeated report of the same name is not
    passed on again."""


@router.post(
    "/tasks/{task}/load",
    dependencies=[Depends(json_only)],
    responses={
        200: described(
            CommandAnswer,
            "The word of who coordinates the transport",
            CommandAnswer("gateway.1-7", done=True),
        ),
        **problems(
            p403="The place where somebody has to look is not in the caller's areas",
            p404="There is no such transport",
            p409="The name of the command was used for another one, or who coordinates the transport is shut out",
            p503="Too many commands wait for an answer",
            p504="Who coordinates the transport has not confirmed in time",
        ),
    },
    response_class=Json,
)
async def load_seen(
    commands: Provided[Commands],
    projection: Provided[Projection],
    caller: Caller,
    visible: Visible,
    note: Noted,
    task: str,
    seen: LoadSeenRequest,
) -> Json:
    """Report on a held transport: whether its load is there (`trouble` is `disputed`), or that a dock is in order (`dock_fails`).

    The transport then counts as delivered, or is announced anew. After `dock_fails`, `there` is false once the dock
    is in order, and true if people have brought the load by hand.
    """
    note.detail |= seen.model_dump(mode="json", exclude_none=True)
    note.waits = True
    view = projection.tasks.view(task)
    if view is None or view.kind != "transport" or visible.task(view) is None:
        raise not_found("task", task, "GET /api/tasks")
    _area_rule(projection, caller, view)
    place = view.coordinator
    must_be_heard(projection, place, "Who coordinates it is shut out", "; readmit it first")
    said = MachineCommand(
        command=seen.command or commands.new_name(),
        kind=MachineCommandKind.LOAD_THERE if seen.there else MachineCommandKind.LOAD_MISSING,
        task=task,
        issued_by=caller.name,
    )
    answer = await commands.give(place, said, by=caller)
    return answered(answer, note, visible)


def _area_rule(projection: Projection, caller: Principal, view: TaskView) -> None:
    """Require that the load's destination, or the place where vehicles fail, is in the caller's areas.

    Raises:
        Problem: 403, it is elsewhere.
    """
    plant = projection.site.plant
    if caller.areas is None:
        return
    place = view.fails_at or view.destination
    near = plant.areas_near(*plant.position_of(place), 0.0) if plant.has_place(place) else ()
    if caller.areas.isdisjoint(near):
        areas = ", ".join(sorted(caller.areas)) or "none"
        raise forbidden(f"{place} is not in your areas ({areas})")
