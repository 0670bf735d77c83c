"""Faults that a person causes in a simulated factory, to watch the effect."""

from __future__ import annotations

from collections.abc import Awaitable
from http import HTTPStatus
from typing import Annotated, TypeVar

import msgspec
from fastapi import APIRouter, Depends
from pydantic import BaseModel, ConfigDict, Field

from dray.errors import UnavailableError
from dray.gateway.access.audit_log import Noted
from dray.gateway.factory.fault_injection import FaultInjection, FaultKind, FaultRefused
from dray.gateway.http.problems import FieldError, Problem, not_found, unusable
from dray.gateway.http.provided import Provided
from dray.gateway.http.request_bodies import json_only
from dray.gateway.http.responses import Json, described, problems
from dray.gateway.live.views import FaultView

router = APIRouter(tags=["fault injection"])

T = TypeVar("T")

MAX_FAULTS = 100
"""Maximum active faults: more than anybody begins by hand, and scripts should end theirs."""


class FaultRequest(BaseModel):
    """A fault as data: its kind, and that kind's fields as in `GET /api/faults`."""

    model_config = ConfigDict(
        extra="allow",
        json_schema_extra={
            "examples": [
                {"kind": "powered_off", "agent": "ATV3"},
                {"kind": "machine_broken", "machine": "M8", "reason": "spindle"},
            ]
        },
    )

    kind: Annotated[str, Field(min_length=1, max_length=64)]


class FaultsAnswer(msgspec.Struct, frozen=True):
    """Active faults, and possible kinds."""

    items: tuple[FaultView, ...]
    """Active ones, oldest first."""
    kinds: tuple[FaultKind, ...]


EXAMPLE = FaultView(
    id="f3",
    kind="powered_off",
    fault={"kind": "powered_off", "agent": "ATV3"},
    agents=("ATV3",),
    began_at_s=1_893_456_000.0,
)

KINDS = (FaultKind("powered_off", "The vehicle or machine is switched off.", ("agent",)),)


@router.get(
    "/faults",
    responses={
        200: described(FaultsAnswer, "Faults", FaultsAnswer((EXAMPLE,), KINDS)),
        **problems(p409="The factory is not simulated"),
    },
    response_class=Json,
)
async def list_faults(faults: Provided[FaultInjection]) -> Json:
    """Active faults begun by hand, and the kinds that can be begun."""
    return Json(FaultsAnswer(faults.shown.views(), faults.injector.kinds))


@router.post(
    "/faults",
    status_code=HTTPStatus.CREATED,
    dependencies=[Depends(json_only)],
    responses={
        201: described(FaultView, "It has begun", EXAMPLE)
        | {"headers": {"Location": {"description": "The fault", "schema": {"type": "string"}}}},
        **problems(
            p409="The factory is not simulated, or too many faults are at work",
            p503="The factory does not answer",
        ),
    },
    response_class=Json,
)
async def begin_fault(faults: Provided[FaultInjection], note: Noted, fault: FaultRequest) -> Json:
    """Begin a fault; it lasts until it is ended."""
    note.detail["kind"] = fault.kind
    injector, shown = faults.injector, faults.shown
    if len(shown.views()) >= MAX_FAULTS:
        raise Problem(
            HTTPStatus.CONFLICT,
            "too-many-faults",
            "Too many faults are at work",
            f"{MAX_FAULTS} have not ended; end some with DELETE /api/faults/ID",
        )
    begun = await _answered(injector.begin(fault.model_dump()))
    shown.put(begun)
    note.target, note.detail["agents"] = begun.id, begun.agents
    return Json(begun, HTTPStatus.CREATED, headers={"Location": f"/api/faults/{begun.id}"})


@router.delete(
    "/faults/{fault}",
    responses={
        200: described(FaultView, "It has ended", EXAMPLE),
        **problems(
            p403="Another site's page asked",
            p404="There is no such fault",
            p409="The factory is not simulated",
            p503="The factory does not answer",
        ),
    },
    response_class=Json,
)
async def end_fault(faults: Provided[FaultInjection], fault: str) -> Json:
    """End a fault."""
    injector, shown = faults.injector, faults.shown
    known = next((view for view in shown.views() if view.id == fault), None)
    if known is None:
        raise not_found("fault", fault, "GET /api/faults")
    await _answered(injector.end(fault))
    shown.drop(fault)
    return Json(known)


async def _answered(asked: Awaitable[T]) -> T:
    """The injector's answer, with its errors as problems."""
    try:
        return await asked
    except FaultRefused as refused:
        raise unusable(FieldError(refused.field, refused.reason)) from None
    except UnavailableError as error:
        raise Problem(
            HTTPStatus.SERVICE_UNAVAILABLE, "no-answer", "The factory does not answer", str(error)
        ) from None
