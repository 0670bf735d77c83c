"""Carrying vehicles away and putting them back: a person reports it for a vehicle that cannot."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Depends
from pydantic import BaseModel, ConfigDict, Field

from dray.gateway.access.audit_log import Noted
from dray.gateway.access.caller import Caller
from dray.gateway.access.gate import forbidden
from dray.gateway.access.principal import Principal
from dray.gateway.factory.carrying import Carrying
from dray.gateway.http.problems import FieldError, not_found, unusable
from dray.gateway.http.provided import Provided
from dray.gateway.http.request_bodies import json_only
from dray.gateway.http.responses import Json, described, problems
from dray.gateway.live.projection import Projection
from dray.gateway.live.views import RemovalView
from dray.gateway.routes.factory.atvs import area_rule
from dray.messages import CommandKind
from dray.plant import Plant

router = APIRouter(tags=["factory"])

REFUSED = problems(
    p403="The vehicle, or the place, is not in the caller's areas",
    p404="There is no such ATV",
    p409="The vehicle is heard; or it is on the floor; or another one holds the place",
)


class CarriedAwayRequest(BaseModel):
    """The report of a person on site that a vehicle is off the floor."""

    model_config = ConfigDict(extra="forbid", json_schema_extra={"examples": [{"off_the_floor": True}]})

    off_the_floor: Annotated[bool, Field(strict=True)]
    """Must be true: other vehicles drive where it stood."""


class PutBackRequest(BaseModel):
    """The place where a vehicle is being put back."""

    model_config = ConfigDict(extra="forbid", json_schema_extra={"examples": [{"place": "P2"}]})

    place: Annotated[str, Field(min_length=1, max_length=128)]
    """A node, or a machine, storage, warehouse, charger or parking place, which stands for its node."""


@router.post(
    "/atvs/{atv}/carried-away",
    dependencies=[Depends(json_only)],
    responses={200: described(RemovalView, "What is said of it, and what is free since"), **REFUSED},
    response_class=Json,
)
async def carry_away(
    carrying: Provided[Carrying],
    projection: Provided[Projection],
    caller: Caller,
    atv: str,
    request: CarriedAwayRequest,
) -> Json:
    """Report that a vehicle was carried away: it is silent and off the floor.

    Its places are freed after enough silence.

    This is possible for any vehicle that holds places others need, even one that was never heard.

    The keepers of reservation tables believe it from `believed_at_s` on, unless the vehicle is heard.
    """
    if caller.areas is not None or not projection.waits.names(atv):
        area_rule(projection, caller, atv, CommandKind.ACKNOWLEDGE)
    if not request.off_the_floor:
        raise unusable(FieldError("off_the_floor", "say true when it is off the floor, and nothing before"))
    await carrying.carry_away(atv, caller)
    return _said(projection, atv)


@router.post(
    "/atvs/{atv}/put-back",
    dependencies=[Depends(json_only)],
    responses={
        200: described(RemovalView, "What is said of it; put it down when `kept` is true"),
        **REFUSED,
    },
    response_class=Json,
)
async def put_back(
    carrying: Provided[Carrying],
    projection: Provided[Projection],
    caller: Caller,
    note: Noted,
    atv: str,
    request: PutBackRequest,
) -> Json:
    """Reserve a place for a vehicle that was carried away.

    When `kept` is true, no other drives there: put it down and switch it on.
    """
    note.detail |= request.model_dump(mode="json")
    area_rule(projection, caller, atv, CommandKind.ACKNOWLEDGE)
    node = _node(projection.site.plant, request.place)
    _must_reach(projection.site.plant, caller, node)
    await carrying.put_back(atv, node, caller)
    return _said(projection, atv)


def _node(plant: Plant, place: str) -> str:
    """The node of a place.

    Raises:
        Problem: 422, there is no such place, or no vehicle may stand there.
    """
    if place not in plant.nodes and place not in plant.places and place not in plant.dwell_points:
        raise unusable(FieldError.of("place", "node_unknown", place=place))
    node = place if place in plant.nodes else plant.node_of(place)
    if node not in plant.stops:
        raise unusable(FieldError.of("place", "in_crossing", node=node))
    return node


def _must_reach(plant: Plant, caller: Principal, node: str) -> None:
    spot = plant.nodes[node]
    if caller.areas is not None and caller.areas.isdisjoint(plant.areas_at(spot.x_m, spot.y_m)):
        areas = ", ".join(sorted(caller.areas)) or "none"
        raise forbidden(f"{node} is not in your areas ({areas})")


def _said(projection: Projection, atv: str) -> Json:
    """The removal of a vehicle, as the answer."""
    view = projection.removals.view(atv)
    if view is None:
        # It was heard while this was stored.
        raise not_found("removal", atv, f"GET /api/atvs/{atv}")
    return Json(view)
