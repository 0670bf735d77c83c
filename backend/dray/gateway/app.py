"""The gateway put together: one FastAPI application for one plant."""

from __future__ import annotations

import time as clock
from collections.abc import AsyncIterator, Callable, Iterable
from contextlib import asynccontextmanager

from fastapi import FastAPI
from prometheus_client.registry import Collector
from starlette.middleware.errors import ServerErrorMiddleware

from dray import __version__
from dray.adapters.security.signing import SigningKey
from dray.gateway.access.caller import takes_files
from dray.gateway.access.gate import Gate
from dray.gateway.access.login.hasher import Hasher
from dray.gateway.access.queries import KnownQueries
from dray.gateway.factory.duty import OperatorHost
from dray.gateway.factory.fault_injection import FaultInjector
from dray.gateway.factory.scenario_play import ScenarioPlayer
from dray.gateway.http import problems
from dray.gateway.http.assets import PREFIX, STATIC, BuiltFiles, Panels
from dray.gateway.http.compression import Compression
from dray.gateway.http.conditional import Conditional
from dray.gateway.http.hosts import Hosts, KnownHost
from dray.gateway.http.middleware import BodyLimit, Readable, SameOrigin, SecurityHeaders, WholeCharacters
from dray.gateway.http.provided import provide
from dray.gateway.live.timescale import TimeScale
from dray.gateway.metrics import Stopwatch
from dray.gateway.routes.openapi import document
from dray.gateway.routes.pages import unknown
from dray.gateway.routes.table import GUARDS, add_routes
from dray.gateway.services import Beside, measure, open_services, restore, running
from dray.plant.model import PlantFile
from dray.ports import Bus
from dray.settings import Settings
from dray.shapes import prepare_shapes
from dray.store import Historian, Store


def create_app(
    *,
    settings: Settings,
    plant: PlantFile,
    bus: Bus,
    store: Store,
    time: TimeScale,
    authority: SigningKey,
    incarnation: int = 1,
    historian: Historian | None = None,
    panels: Panels | None = None,
    faults: FaultInjector | None = None,
    collectors: Iterable[Collector] = (),
    wall_s: Callable[[], float] = clock.time,
    hasher: Hasher | None = None,
    beside: Beside | None = None,
    operators: OperatorHost | None = None,
    scenario: ScenarioPlayer | None = None,
) -> FastAPI:
    """Put a gateway together. It joins the bus when the server starts, and leaves it at the end.

    Args:
        settings: limits and rates.
        plant: a plant file without faults.
        bus: the agents' bus; it must call us on the server's event loop.
        store: open and up to date; its opener closes it.
        time: plant clock and wall clock.
        authority: signs grants for people's commands; vehicles trust it.
        incarnation: number of starts of this plant's agents (`Store.next_incarnation`).
        historian: runs with the application, if given.
        panels: templates and built files, instead of the package's own.
        faults: injects faults, where the factory is simulated.
        collectors: metrics of other parts of this process.
        wall_s: the wall clock.
        hasher: replaces the usual hasher of secrets.
        beside: runs with the application: the stop path.
        operators: runs the agents of people on duty; None where nobody can be on duty.
        scenario: the scenario's player, where the factory is simulated; None without a scenario.
    """
    prepare_shapes()

    @asynccontextmanager
    async def lifespan(app: FastAPI) -> AsyncIterator[None]:
        services = open_services(
            settings=settings,
            plant=plant,
            bus=bus,
            store=store,
            time=time,
            authority=authority,
            incarnation=incarnation,
            historian=historian,
            panels=panels,
            faults=faults,
            scenario=scenario,
            collectors=collectors,
            wall_s=wall_s,
            hasher=hasher,
            operators=operators,
        )
        await restore(services)
        services.scenario.follow()
        measure(services)
        provide(app, services.by_type(), wall_s)
        async with running(services, beside):
            yield

    app = FastAPI(
        title="Dray",
        version=__version__,
        lifespan=lifespan,
        openapi_url="/api/openapi.json",
        # FastAPI's pages load scripts from other sites; ours is in `routes.pages.docs`.
        docs_url=None,
        redoc_url=None,
        redirect_slashes=False,
        dependencies=GUARDS,
    )
    add_routes(app)
    app.mount(PREFIX.rstrip("/"), BuiltFiles(directory=STATIC, check_dir=False), "static")
    problems.install(app)
    unknown.install(app)
    document.install(app)
    _add_middleware(app, settings)
    return app


def _add_middleware(app: FastAPI, settings: Settings) -> None:
    """Add the middleware that every request passes; the last one added is the outermost."""
    app.add_middleware(WholeCharacters, takes_files=takes_files)
    app.add_middleware(BodyLimit, bulk_bytes=settings.body_limit_bytes, takes_files=takes_files)
    app.add_middleware(Conditional)
    app.add_middleware(Compression)
    app.add_middleware(KnownQueries, routes=app.routes)
    app.add_middleware(Gate)
    app.add_middleware(SameOrigin)
    app.add_middleware(KnownHost, hosts=Hosts.of(settings))
    app.add_middleware(Readable)
    # FastAPI's own bug handler is outside of all middleware: its answers would lack the headers.
    app.add_middleware(ServerErrorMiddleware, handler=problems.on_bug)
    app.add_middleware(SecurityHeaders)
    app.add_middleware(Stopwatch)
