"""Me: the caller and its rights."""

from __future__ import annotations

import msgspec
from fastapi import APIRouter

from dray.gateway.access.caller import Caller
from dray.gateway.http.responses import Json, described

router = APIRouter(tags=["access"])


class MeAnswer(msgspec.Struct, frozen=True):
    """The caller."""

    kind: str
    """person, key or admin."""
    id: str
    name: str
    role: str | None
    """manager or operator; null for keys and the administrator."""
    areas: tuple[str, ...] | None
    """Areas to which it is limited; null for the whole plant."""
    station: str
    """An operator's machine; empty if there is none."""
    scopes: tuple[str, ...]
    expires_at_s: float | None
    """Latest time of the next login; null for never."""


EXAMPLE = MeAnswer(
    kind="person",
    id="operator-area1",
    name="Operator, North",
    role="operator",
    areas=("AREA1",),
    station="M1",
    scopes=("alerts:acknowledge", "factory:read", "transports:call", "vehicles:command", "vehicles:stop"),
    expires_at_s=1_893_492_000.0,
)


@router.get("/me", responses={200: described(MeAnswer, "Who you are", EXAMPLE)}, response_class=Json)
async def get_me(caller: Caller) -> Json:
    """Who you are, and what you may do."""
    return Json(
        MeAnswer(
            kind=caller.kind,
            id=caller.id,
            name=caller.name,
            role=None if caller.role is None else caller.role.value,
            areas=None if caller.areas is None else tuple(sorted(caller.areas)),
            station=caller.station,
            scopes=tuple(sorted(caller.scopes)),
            expires_at_s=caller.expires_at_s,
        )
    )
