"""Parameters of several routers, beside services (`http.provided`) and the caller (`access.caller`)."""

from __future__ import annotations

from typing import Annotated

from fastapi import Depends

from dray.gateway.access.caller import Caller
from dray.gateway.access.principal import Scope
from dray.gateway.http.provided import Provided
from dray.gateway.live.projection import Projection
from dray.gateway.live.visibility import Visibility, visibility_of


async def _visible(projection: Provided[Projection], caller: Caller) -> Visibility:
    return visibility_of(projection, caller.areas, orders=caller.may(Scope.ORDERS_READ))


Visible = Annotated[Visibility, Depends(_visible)]
"""What the caller may see of the plant now."""
