"""Routers, one per noun. They say what a request and its answer look like, and leave the rest to others."""

from __future__ import annotations

from dray.gateway.routes import (
    agents,
    alerts,
    atvs,
    audit,
    customer,
    docs,
    events,
    faults,
    health,
    imports,
    inventory,
    kpis,
    login,
    machines,
    me,
    orders,
    pages,
    plant,
    products,
    promises,
    stream,
    tasks,
    track,
    traffic,
)

API = (
    # Its path looks like that of an order, so it comes first.
    imports,
    orders,
    track,
    products,
    inventory,
    machines,
    atvs,
    tasks,
    alerts,
    agents,
    promises,
    events,
    kpis,
    plant,
    traffic,
    faults,
    me,
    audit,
)
"""Those that OpenAPI tells of."""

REST = (docs, stream, health, login, pages, customer)

__all__ = ["API", "REST"]
