"""The gateway put together: one FastAPI application for one plant."""

from __future__ import annotations

import asyncio
import time as clock
from collections.abc import AsyncIterator, Callable, Iterable
from contextlib import AbstractAsyncContextManager, AsyncExitStack, asynccontextmanager, suppress

from fastapi import Depends, FastAPI
from prometheus_client.registry import Collector
from starlette.middleware.errors import ServerErrorMiddleware

from dray import __version__
from dray.adapters.signing import SigningKey
from dray.errors import UnavailableError
from dray.gateway import openapi, problems
from dray.gateway.access.access import open_access
from dray.gateway.access.caller import admitted
from dray.gateway.access.gate import Gate
from dray.gateway.access.hasher import Hasher
from dray.gateway.access.trail import Trail
from dray.gateway.alertdesk import AlertDesk
from dray.gateway.commands import Commands
from dray.gateway.conditional import Conditional
from dray.gateway.desk import STRATEGIST, Desk
from dray.gateway.endings import Endings
from dray.gateway.exclusiondesk import ExclusionDesk
from dray.gateway.faultdesk import FaultDesk
from dray.gateway.health import Health
from dray.gateway.hosts import Hosts, KnownHost
from dray.gateway.idempotency import KEYS_KEPT_S
from dray.gateway.ledger import Ledger
from dray.gateway.lookout import Lookout
from dray.gateway.metrics import Metrics, Stopwatch
from dray.gateway.metrics.history import History
from dray.gateway.metrics.state import State
from dray.gateway.panels import PREFIX, STATIC, BuiltFiles, Panels
from dray.gateway.parts import Intake, Parts
from dray.gateway.peer import Peer
from dray.gateway.presence import Presence
from dray.gateway.projection import Projection
from dray.gateway.queries import KnownQueries
from dray.gateway.recall import recall_news
from dray.gateway.rollcall import RollCall
from dray.gateway.routes import API, REST
from dray.gateway.sampler import Sampler
from dray.gateway.shields import BodyLimit, SameOrigin, SecurityHeaders
from dray.gateway.sidework import SideWork
from dray.gateway.stream import Hub
from dray.gateway.timescale import TimeScale
from dray.messages import Message
from dray.messages.keys import Keys
from dray.plant.model import PlantFile
from dray.ports import Bus
from dray.settings import Settings
from dray.store import Historian, Store
from dray.store.placing import Placing


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
    faults: FaultDesk | None = None,
    collectors: Iterable[Collector] = (),
    wall_s: Callable[[], float] = clock.time,
    hasher: Hasher | None = None,
    beside: Callable[[Parts], AbstractAsyncContextManager[None]] | None = None,
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
        beside: runs as long as the application does: the way for stops.
    """

    @asynccontextmanager
    async def lifespan(app: FastAPI) -> AsyncIterator[None]:
        metrics = Metrics(collectors)

        def overhear(sender: str, message: Message) -> None:
            metrics.meter.hear(message)
            if sender == STRATEGIST:
                presence.heard()

        peer = Peer(bus, Keys(plant.plant), settings.gateway_name, incarnation, overhear)
        presence = Presence(peer.send)
        products = frozenset(product.id for product in plant.products)
        projection = Projection(plant, time, trials=faults is not None, wall_s=wall_s)
        desk = Desk(send=peer.send, time=time, wall_s=wall_s, products=products)
        commands = Commands(
            peer.send,
            authority=authority,
            projection=projection,
            floor=projection.site.plant,
            plant_s=lambda: time.to_plant_s(wall_s()),
            wall_s=wall_s,
            speed=time.speed,
            name=f"{settings.gateway_name}.{incarnation}",
            timeout_s=settings.command_timeout_s,
        )
        parts = Parts(
            settings=settings,
            store=store,
            historian=historian,
            wall_s=wall_s,
            access=open_access(settings, store, wall_s, hasher),
            projection=projection,
            desk=desk,
            endings=Endings(store, desk, projection, wall_s),
            commands=commands,
            alerts=AlertDesk(projection, store, wall_s),
            exclusions=ExclusionDesk(
                store, projection, commands, peer.tell_all, wall_s=wall_s, own=settings.gateway_name
            ),
            ledger=Ledger(store),
            hub=Hub(
                projection,
                wall_s=wall_s,
                rate_hz=settings.stream_rate_hz,
                queue_frames=settings.stream_queue_frames,
                clients=settings.stream_clients,
                each=settings.stream_clients_each,
            ),
            peer=peer,
            presence=presence,
            health=Health(store, peer, presence, historian),
            metrics=metrics,
            panels=panels or Panels(),
            faults=faults,
            side_work=SideWork(),
            keys_at_work=set(),
            intake=Intake(Placing(store.database, keys_kept_s=KEYS_KEPT_S, lines_kept=settings.audit_kept)),
        )
        lookout = Lookout(store, projection, desk)
        await _recall(parts, plant, lookout, time)
        metrics.add(State(parts))
        if historian is not None:
            metrics.add(History(historian))
        app.state.parts = parts
        sampler = Sampler(projection, store, wall_s)
        roll_call = RollCall(store, desk, wall_s)
        async with AsyncExitStack() as stack:
            if historian is not None:
                await stack.enter_async_context(historian.running(projection.fold))
            stack.push_async_callback(sampler.sample)
            stack.callback(peer.leave)
            stack.callback(parts.side_work.close)
            stack.push_async_callback(_last_lines, parts.access.trail)
            peer.join(projection, desk, parts.endings, parts.commands)
            tasks = await stack.enter_async_context(asyncio.TaskGroup())
            running = [
                tasks.create_task(each.run())
                for each in (
                    parts.desk,
                    parts.endings,
                    parts.alerts,
                    parts.exclusions,
                    parts.hub,
                    parts.access,
                    parts.access.watch,
                    parts.access.trail,
                    presence,
                    sampler,
                    roll_call,
                    lookout,
                )
            ]
            await roll_call.begin()
            if beside is not None:
                await parts.access.learn()
                await stack.enter_async_context(beside(parts))
            yield
            for task in running:
                task.cancel()

    app = FastAPI(
        title="Dray",
        version=__version__,
        lifespan=lifespan,
        openapi_url="/api/openapi.json",
        # FastAPI's pages load their scripts from elsewhere; ours is in `routes.docs`.
        docs_url=None,
        redoc_url=None,
        redirect_slashes=False,
        dependencies=[Depends(admitted)],
    )
    for module in API:
        app.include_router(module.router, prefix="/api")
    for module in REST:
        inside = module.__name__.rpartition(".")[2] in {"docs", "stream"}
        app.include_router(module.router, prefix="/api" if inside else "")
    app.mount(PREFIX.rstrip("/"), BuiltFiles(directory=STATIC, check_dir=False), "static")
    problems.install(app)
    openapi.install(app)
    _shield(app, settings)
    return app


async def _last_lines(trail: Trail) -> None:
    """Write what waits for the audit log, if the database is there."""
    with suppress(UnavailableError):
        await trail.catch_up()


def _shield(app: FastAPI, settings: Settings) -> None:
    """What every request passes before it reaches a router; the last one added is the outermost."""
    app.add_middleware(BodyLimit, bulk_bytes=settings.body_limit_bytes)
    app.add_middleware(Conditional)
    app.add_middleware(KnownQueries, routes=app.routes)
    app.add_middleware(Gate)
    app.add_middleware(SameOrigin)
    app.add_middleware(KnownHost, hosts=Hosts.of(settings))
    # FastAPI's own handler of bugs stands outside of all shields: its answers would lack the headers.
    app.add_middleware(ServerErrorMiddleware, handler=problems.on_bug)
    app.add_middleware(SecurityHeaders)
    app.add_middleware(Stopwatch)


async def _recall(parts: Parts, plant: PlantFile, lookout: Lookout, time: TimeScale) -> None:
    """Read from SQL what must be known before anybody is heard or answered.

    Raises:
        UnavailableError: the database cannot be read or written.
    """
    async with parts.store.write() as work:
        await work.products.replace(plant.products)
    await lookout.begin()
    async with parts.store.read() as work:
        await recall_news(work, parts.projection.news, time)
    await parts.alerts.begin()
    await parts.exclusions.begin()
