"""Machines, as their last heartbeats told."""

from __future__ import annotations

from fastapi import APIRouter

from dray.gateway.answers import PAGE, Cursor, Json, Limit, described, list_of, page, problems
from dray.gateway.parts import Gateway
from dray.gateway.problems import not_found
from dray.gateway.seen import Seen
from dray.gateway.views import MachineView

router = APIRouter(tags=["factory"])


@router.get("/machines", responses={200: list_of(MachineView, "Machines, by id")}, response_class=Json)
async def list_machines(gateway: Gateway, seen: Seen, cursor: Cursor = None, limit: Limit = PAGE) -> Json:
    """Machines that have been heard."""
    machines = [view for each in gateway.projection.machines.views() if (view := seen.machine(each))]
    return page(machines, lambda machine: machine.id, cursor, limit)


@router.get(
    "/machines/{machine}",
    responses={200: described(MachineView, "The machine"), **problems(p404="There is no such machine")},
    response_class=Json,
)
async def get_machine(gateway: Gateway, seen: Seen, machine: str) -> Json:
    """One machine."""
    whole = gateway.projection.machines.view(machine)
    view = whole and seen.machine(whole)
    if view is None:
        raise not_found("machine", machine, "GET /api/machines")
    return Json(view)
