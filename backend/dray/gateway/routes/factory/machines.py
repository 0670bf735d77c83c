"""Machines, by their last heartbeats."""

from __future__ import annotations

from fastapi import APIRouter

from dray.gateway.http.problems import not_found
from dray.gateway.http.provided import Provided
from dray.gateway.http.responses import PAGE, Cursor, Json, Limit, described, list_of, page, problems
from dray.gateway.live.projection import Projection
from dray.gateway.live.views import MachineView
from dray.gateway.routes.parameters import Visible

router = APIRouter(tags=["factory"])


@router.get("/machines", responses={200: list_of(MachineView, "Machines, by id")}, response_class=Json)
async def list_machines(
    projection: Provided[Projection], visible: Visible, cursor: Cursor = None, limit: Limit = PAGE
) -> Json:
    """Machines that have been heard."""
    machines = [view for each in projection.machines.views() if (view := visible.machine(each))]
    return page(machines, lambda machine: machine.id, cursor, limit)


@router.get(
    "/machines/{machine}",
    responses={200: described(MachineView, "The machine"), **problems(p404="There is no such machine")},
    response_class=Json,
)
async def get_machine(projection: Provided[Projection], visible: Visible, machine: str) -> Json:
    """One machine."""
    whole = projection.machines.view(machine)
    view = whole and visible.machine(whole)
    if view is None:
        raise not_found("machine", machine, "GET /api/machines")
    return Json(view)
