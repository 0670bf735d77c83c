"""All routers, and where their paths begin."""

from __future__ import annotations

from fastapi import APIRouter, Depends, FastAPI

from dray.gateway.access.caller import admitted
from dray.gateway.routes import health, me, plant, products, stream
from dray.gateway.routes.factory import (
    agents,
    alerts,
    atvs,
    duty,
    faults,
    inventory,
    machine_commands,
    machines,
    plant_drafts,
    tasks,
)
from dray.gateway.routes.factory.floor import carrying, closures, obstacles, traffic, waits
from dray.gateway.routes.history import audit, events, kpis, promises
from dray.gateway.routes.orders import imports, orders, timeline, track, transports
from dray.gateway.routes.pages import customer, docs, login, panels

API = (
    # Its path looks like that of an order, so it comes first.
    imports,
    orders,
    timeline,
    track,
    transports,
    products,
    inventory,
    machine_commands,
    machines,
    atvs,
    carrying,
    tasks,
    alerts,
    agents,
    closures,
    duty,
    plant_drafts,
    obstacles,
    promises,
    events,
    kpis,
    plant,
    traffic,
    waits,
    faults,
    me,
    audit,
)
"""Those that OpenAPI tells of."""

BESIDE = (docs, stream)
"""Under `/api` too, and not in OpenAPI."""

REST = (health, login, panels, customer)


GUARDS = (Depends(admitted),)
"""Of every route, and of whichever an application may get beside these."""


def _joined() -> APIRouter:
    router = APIRouter(dependencies=GUARDS)
    for module in (*API, *BESIDE):
        router.include_router(module.router, prefix="/api")
    for module in REST:
        router.include_router(module.router)
    return router


_ROUTER = _joined()
"""One for all applications of a process: FastAPI reads the signature of every handler once."""


def add_routes(app: FastAPI) -> None:
    """Let an application answer what routers answer."""
    app.router.routes.extend(_ROUTER.routes)
