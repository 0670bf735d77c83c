"""All routers and their path prefixes."""

from __future__ import annotations

from fastapi import APIRouter, Depends, FastAPI

from dray.gateway.access.caller import admitted
from dray.gateway.routes import health, keys, me, people, plant, priorities, stream
from dray.gateway.routes.factory import (
    agents,
    alerts,
    atvs,
    duty,
    faults,
    inventory,
    loads,
    machine_commands,
    machines,
    plant_drafts,
    scenario,
    station_commands,
    tasks,
)
from dray.gateway.routes.factory.floor import areas, carrying, closures, obstacles, traffic, waits
from dray.gateway.routes.history import alerts as alert_history
from dray.gateway.routes.history import audit, events, kept, kpis, promises, quality, replay, reports
from dray.gateway.routes.history import tasks as task_history
from dray.gateway.routes.orders import (
    change_feed,
    changes,
    imports,
    orders,
    schedules,
    timeline,
    track,
    transports,
)
from dray.gateway.routes.pages import call, customer, docs, login, panels
from dray.gateway.routes.products import imports as product_imports
from dray.gateway.routes.products import products
from dray.gateway.routes.products import removal as product_removal

API = (
    # Its path also matches that of an order, so it comes first.
    imports,
    orders,
    change_feed,
    changes,
    timeline,
    track,
    transports,
    schedules,
    product_imports,
    products,
    product_removal,
    inventory,
    machine_commands,
    machines,
    station_commands,
    atvs,
    carrying,
    # Its path also matches that of a task, so it comes first.
    task_history,
    tasks,
    loads,
    alerts,
    alert_history,
    agents,
    closures,
    areas,
    duty,
    plant_drafts,
    obstacles,
    promises,
    events,
    kept,
    kpis,
    quality,
    replay,
    reports,
    plant,
    priorities,
    traffic,
    waits,
    faults,
    scenario,
    me,
    people,
    keys,
    audit,
)
"""Routers in OpenAPI."""

BESIDE = (docs, stream)
"""Routers under `/api` that are not in OpenAPI."""

REST = (health, login, panels, customer, call)


GUARDS = (Depends(admitted),)
"""Dependencies of every route, and of any added later."""


def _joined() -> APIRouter:
    router = APIRouter(dependencies=GUARDS)
    for module in (*API, *BESIDE):
        router.include_router(module.router, prefix="/api")
    for module in REST:
        router.include_router(module.router)
    return router


_ROUTER = _joined()
"""One router for all applications of a process: FastAPI reads every handler's signature only once."""


def add_routes(app: FastAPI) -> None:
    """Add all routes to an application."""
    app.router.routes.extend(_ROUTER.routes)
