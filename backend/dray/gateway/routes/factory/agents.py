"""Agents: shutting them out, and readmitting them."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Depends, Path
from pydantic import BaseModel, ConfigDict

from dray.gateway.access.audit_log import Noted
from dray.gateway.access.caller import Caller
from dray.gateway.factory.exclusions import Exclusions
from dray.gateway.http.problems import not_found
from dray.gateway.http.provided import Provided
from dray.gateway.http.request_bodies import Line, json_only
from dray.gateway.http.responses import PAGE, Cursor, Json, Limit, described, list_of, page, problems
from dray.gateway.live.projection import Projection
from dray.messages.keys import GATE, HISTORIAN, STRATEGISTS
from dray.store import Store
from dray.store.factory.exclusions import Exclusion

router = APIRouter(tags=["agents"])

AgentId = Annotated[str, Path(max_length=128)]

EXAMPLE = Exclusion("ATV3", "accepts transports and does not move", "Early shift", 1_893_456_000.0)


class ShutOutRequest(BaseModel):
    """Why an agent is shut out."""

    model_config = ConfigDict(
        extra="forbid", json_schema_extra={"examples": [{"reason": "accepts transports and does not move"}]}
    )

    reason: Line
    """Shown in the audit log, and to everybody who sees the agent on a panel."""


@router.get(
    "/agents/shut-out",
    responses={200: list_of(Exclusion, "Agents that are shut out, by id")},
    response_class=Json,
)
async def list_shut_out(store: Provided[Store], cursor: Cursor = None, limit: Limit = PAGE) -> Json:
    """Agents that are shut out, by whom and why."""
    async with store.read() as work:
        exclusions = await work.exclusions.all()
    return page(exclusions, lambda each: each.agent, cursor, limit)


@router.post(
    "/agents/{agent}/shut-out",
    dependencies=[Depends(json_only)],
    responses={
        200: described(Exclusion, "It is shut out; of one that was before, the first decision", EXAMPLE),
        **problems(
            p404="There is no such agent",
            p409="It is the gateway that was asked, or too many are shut out",
        ),
    },
    response_class=Json,
)
async def shut_out(
    exclusions: Provided[Exclusions],
    projection: Provided[Projection],
    caller: Caller,
    note: Noted,
    agent: AgentId,
    request: ShutOutRequest,
) -> Json:
    """Shut an agent out at once: all agents ignore it, and others take its work.

    A vehicle is asked to stop. The exclusion lasts until `readmit`, over restarts and without the gateway.
    """
    note.detail["reason"] = request.reason
    if agent != exclusions.own and not _is_known(projection, agent):
        raise not_found("agent", agent, "GET /api/atvs and GET /api/machines, with strategist and historian,")
    return Json(await exclusions.shut_out(agent, request.reason, caller.name))


@router.post(
    "/agents/{agent}/readmit",
    responses={
        200: described(Exclusion, "It is heard again; why it was not", EXAMPLE),
        **problems(p403="Another site's page asked", p404="It is not shut out"),
    },
    response_class=Json,
)
async def readmit(exclusions: Provided[Exclusions], note: Noted, agent: AgentId) -> Json:
    """Readmit an agent. A vehicle stays stopped until somebody acknowledges and resumes it."""
    ended = await exclusions.readmit(agent)
    note.detail["shut_out_for"] = ended.reason
    return Json(ended)


def _is_known(projection: Projection, agent: str) -> bool:
    return (
        agent in projection.atvs
        or projection.waits.names(agent)
        or agent in projection.site.plant.machines
        or agent in projection.site.plant.stores
        or agent in STRATEGISTS
        or agent in {GATE, HISTORIAN}
    )
