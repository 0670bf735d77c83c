"""Priorities: how soon each is wanted, and how long others may pass a waiting transport."""

from __future__ import annotations

import msgspec
from fastapi import APIRouter

from dray.gateway.http.responses import Json, described
from dray.priorities import ORDER_WITHIN_S, TRANSPORT_WITHIN_S, Priority
from dray.protocol.contract_net.auction_rules import PATIENCE_S

router = APIRouter(tags=["plant"])


class PrioritiesAnswer(msgspec.Struct, frozen=True, kw_only=True):
    """The meaning of priorities, in seconds of the plant's clock."""

    transports: dict[Priority, float]
    """Time within which a plain transport without due time is wanted."""
    orders: dict[Priority, float]
    """Time from release within which an order is wanted."""
    passed_most_s: float
    """Maximum time for which later calls may pass an announced transport; after it, later calls queue behind
    it."""


ANSWER = PrioritiesAnswer(transports=TRANSPORT_WITHIN_S, orders=ORDER_WITHIN_S, passed_most_s=PATIENCE_S)


@router.get("/priorities", responses={200: described(PrioritiesAnswer, "They", ANSWER)}, response_class=Json)
async def get_priorities() -> Json:
    """How soon each priority is wanted, and how long a waiting transport can be passed."""
    return Json(ANSWER)
