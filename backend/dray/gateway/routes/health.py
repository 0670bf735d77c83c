"""Health and metrics, for process monitoring."""

from __future__ import annotations

from http import HTTPStatus

from fastapi import APIRouter, Response
from prometheus_client import CONTENT_TYPE_LATEST

from dray.gateway.http.problems import AGAIN_S, FieldError, Problem
from dray.gateway.http.provided import Provided
from dray.gateway.http.responses import Json
from dray.gateway.live.health import NEEDED, Health, Part
from dray.gateway.metrics import Metrics

router = APIRouter(include_in_schema=False)


@router.get("/healthz")
async def healthz() -> Json:
    """The process answers."""
    return Json({"status": "ok"})


@router.get("/readyz")
async def readyz(health: Provided[Health]) -> Json:
    """Whether orders can be taken, and the state of every part, needed or not."""
    parts = await health.examine()
    faults = [FieldError(name, part.reason) for name, part in parts.items() if _hinders(name, part)]
    if faults:
        raise Problem(
            HTTPStatus.SERVICE_UNAVAILABLE,
            "not-ready",
            "Not ready",
            "; ".join(f"{fault.field}: {fault.reason}" for fault in faults),
            errors=faults,
            headers={"Retry-After": str(AGAIN_S)},
        )
    return Json({"status": "ready", "parts": parts})


@router.get("/metrics")
async def metrics(health: Provided[Health], metrics: Provided[Metrics]) -> Response:
    """In Prometheus' text format."""
    await health.examine()
    return Response(metrics.text(), headers={"Content-Type": CONTENT_TYPE_LATEST})


def _hinders(name: str, part: Part) -> bool:
    return not part.ok and name in NEEDED
