"""Seen: what the caller sees of the plant, for routers."""

from __future__ import annotations

from typing import Annotated

from fastapi import Depends

from dray.gateway.access.caller import Caller
from dray.gateway.access.principal import Scope
from dray.gateway.parts import Gateway
from dray.gateway.projection.sight import Sight, sight


async def seen(gateway: Gateway, caller: Caller) -> Sight:
    """What the caller sees at this moment."""
    return sight(gateway.projection, caller.areas, orders=caller.may(Scope.ORDERS_READ))


Seen = Annotated[Sight, Depends(seen)]
"""A router's parameter."""
