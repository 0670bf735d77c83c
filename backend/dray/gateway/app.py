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
    """Put a gateway together. It joins the bus when the server starts, and leaves it when it ends.

    Args:
        settings: limits and rates.
        plant: a plant file without faults.
        bus: where the agents meet; it must call us on the server's event loop.
        store: open and up to date; whoever opened it closes it.
        time: the two clocks.
        authority: grants people's commands to vehicles that trust it.
        incarnation: how often this plant's agents have been started (`Store.next_incarnation`).
        historian: runs as long as the application does, when given.
        panels: templates and built files, when not the ones that came with this package.
        faults: lets things go wrong, where the factory is simulated.
        collectors: of metrics that others in this process have.
        wall_s: the wall clock.
        hasher: of secrets, when not the usual one.
        beside: runs as long as the application does: the stop path.
        operators: runs the agents of people on duty; None where nobody can be.
        scenario: what the factory plays, where it is simulated; None where nobody wrote its day.
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
        # FastAPI's pages load their scripts from elsewhere; ours is in `routes.pages.docs`.
        docs_url=None,
        redoc_url=None,
        redirect_slashes=False,
        dependencies=GUARDS,
    )
    add_routes(app)
    app.mount(PREFIX.rstrip("/"), BuiltFiles(directory=STATIC, check_dir=False), "static")
    problems.install(app)
    document.install(app)
    _add_middleware(app, settings)
    return app


def _add_middleware(app: FastAPI, settings: Settings) -> None:
    """What every request passes before it reaches a router; the last one added is the outermost."""
    app.add_middleware(WholeCharacters, takes_files=takes_files)
    app.add_middleware(BodyLimit, bulk_bytes=settings.body_limit_bytes, takes_files=takes_files)
    app.add_middleware(Conditional)
    app.add_middleware(Compression)
    app.add_middleware(KnownQueries, routes=app.routes)
    app.add_middleware(Gate)
    app.add_middleware(SameOrigin)
    app.add_middleware(KnownHost, hosts=Hosts.of(settings))
    app.add_middleware(Readable)
    # FastAPI's own handler of bugs stands outside of all middleware: its answers would lack the headers.
    app.add_middleware(ServerErrorMiddleware, handler=problems.on_bug)
    app.add_middleware(SecurityHeaders)
    app.add_middleware(Stopwatch)
