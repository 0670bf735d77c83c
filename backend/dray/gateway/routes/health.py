"""Health: for whoever watches over the process. True, not hopeful."""

from __future__ import annotations

from http import HTTPStatus

from fastapi import APIRouter

from dray.errors import UnavailableError
from dray.gateway.answers import Json
from dray.gateway.parts import Gateway
from dray.gateway.problems import Problem

router = APIRouter(include_in_schema=False)


@router.get("/healthz")
async def healthz() -> Json:
    """The process answers."""
    return Json({"status": "ok"})


@router.get("/readyz")
async def readyz(gateway: Gateway) -> Json:
    """Orders can be taken: the database answers and can be written, and we are on the bus."""
    faults = []
    try:
        async with gateway.store.read() as work:
            await work.ping()
    except UnavailableError:
        faults.append("the database does not answer")
    if gateway.historian is not None and gateway.historian.failing:
        faults.append("the historian cannot write to the database")
    if not gateway.peer.joined:
        faults.append("the gateway is not on the bus")
    if faults:
        raise Problem(
            HTTPStatus.SERVICE_UNAVAILABLE,
            "not-ready",
            "Not ready",
            "; ".join(faults),
            headers={"Retry-After": "5"},
        )
    projection = gateway.projection
    return Json({"status": "ready", "heard": projection.heard, "ignored": projection.ignored})
