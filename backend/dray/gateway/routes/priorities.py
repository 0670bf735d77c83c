"""Priorities: how soon each is wanted, and for how long what waits lets others pass."""

from __future__ import annotations

import msgspec
from fastapi import APIRouter

from dray.gateway.http.responses import Json, described
from dray.priorities import ORDER_WITHIN_S, TRANSPORT_WITHIN_S, Priority
from dray.protocol.contract_net.auction_rules import PATIENCE_S

router = APIRouter(tags=["plant"])


class PrioritiesAnswer(msgspec.Struct, frozen=True, kw_only=True):
    """What priorities mean, in seconds of the plant's clock."""

    transports: dict[Priority, float]
    """Within which a plain transport is wanted where no time is given..."""
    orders: dict[Priority, float]
    """...and an order, from its release on."""
    passed_most_s: float
    """For how long a transport that was given out is passed by what is called for after it, at the most. What is called for later goes behind it."""


ANSWER = PrioritiesAnswer(transports=TRANSPORT_WITHIN_S, orders=ORDER_WITHIN_S, passed_most_s=PATIENCE_S)


@router.get("/priorities", responses={200: described(PrioritiesAnswer, "They", ANSWER)}, response_class=Json)
async def get_priorities() -> Json:
    """How soon each priority is wanted, and for how long what waits is passed at the most."""
    return Json(ANSWER)
