"""Machines, as their last heartbeats told."""

from __future__ import annotations

from fastapi import APIRouter

from dray.gateway.answers import PAGE, Cursor, Json, Limit, described, list_of, page, problems
from dray.gateway.parts import Gateway
from dray.gateway.problems import not_found
from dray.gateway.views import MachineView

router = APIRouter(tags=["factory"])


@router.get("/machines", responses={200: list_of(MachineView, "Machines, by id")}, response_class=Json)
async def list_machines(gateway: Gateway, cursor: Cursor = None, limit: Limit = PAGE) -> Json:
    """Machines that have been heard."""
    return page(gateway.projection.machines.views(), lambda machine: machine.id, cursor, limit)


@router.get(
    "/machines/{machine}",
    responses={200: described(MachineView, "The machine"), **problems(p404="There is no such machine")},
    response_class=Json,
)
async def get_machine(gateway: Gateway, machine: str) -> Json:
    """One machine."""
    view = gateway.projection.machines.view(machine)
    if view is None:
        raise not_found("machine", machine, "GET /api/machines")
    return Json(view)
