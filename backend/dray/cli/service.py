"""What `dray up` runs: a simulated factory in a thread of its own, and the gateway on this one.

The start goes in the order of what may fail: the port, the database, the factory. What was opened is
closed in the opposite order, whatever happens.
"""

from __future__ import annotations

import asyncio
import contextlib
import shlex
import socket
import time
from collections.abc import AsyncIterator, Awaitable, Callable, Coroutine, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace

import typer
from fastapi import FastAPI
from opentelemetry.sdk.trace import TracerProvider
from prometheus_client import Metric
from pydantic import SecretStr
from sqlalchemy import URL, make_url

from dray import __version__
from dray.adapters.metrics_port import metrics_port
from dray.adapters.signing import SigningKey, TrustedKeys
from dray.cli.authority import authority_of
from dray.cli.customers import place_demand
from dray.cli.logs import prepare_logs, quieten
from dray.cli.meters.factory import FactoryMeter
from dray.cli.newcomers import welcome
from dray.cli.readiness import tell_ready
from dray.cli.serving import Server, address_of, listen, stopped_by_signals
from dray.cli.stopway import StopWay, listen_for_stops
from dray.cli.traces import traced, watched
from dray.cli.trials import SimFaultDesk
from dray.gateway.access.tokens import new_token
from dray.gateway.app import create_app
from dray.gateway.desk import STRATEGIST
from dray.gateway.parts import Parts
from dray.gateway.timescale import TimeScale
from dray.messages.keys import Keys
from dray.plant import Plant
from dray.ports import Bus
from dray.settings import Settings
from dray.store import Historian, Store, open_store
from dray.store.clocks import Clocks
from dray_sim.bridge import BridgedBus, SimThread
from dray_sim.factory import SimFactory
from dray_sim.faults import Faults
from dray_sim.floor import NEARLY_EMPTY_FRAC
from dray_sim.loop import clock, paced

BUILDING_S = 60.0
"""Longest wait for the factory to be built: one of 1,000 vehicles takes some seconds."""

GREETING = """\
Dray {version}: {plant}, {machines} machines and {vehicles} vehicles, {speed:g} x real time
  Management panel  {url}/
  Operator panel    {url}/operator
  API               {url}/api/docs
  Database          {database}
"""

FOR_ADMIN = """\
  Admin token       {token}
"""

LINKS = """\
Each of these links logs in once, within a day:
{links}
Whoever has a secret needs no link: dray user password manager{db}, dray user pin NAME{db}.
"""


@dataclass(frozen=True, slots=True)
class Service:
    """What is to be run.

    Attributes:
        settings: the gateway's.
        plant: the factory's.
        speed: factory seconds per real second.
        seed: of everything that is left to chance.
        demand: place orders too.
    """

    settings: Settings
    plant: Plant
    speed: float
    seed: int
    demand: bool


@dataclass(frozen=True, slots=True)
class Inside:
    """What the outside needs of a factory that has been built.

    Attributes:
        factory: to be used in its own thread only, except for reading what it counts.
        faults: to be used in the factory's thread only.
        time: the factory's clock and ours.
    """

    factory: SimFactory
    faults: Faults
    time: TimeScale


Factory = SimThread[Inside]


async def run_service(service: Service) -> None:
    """Run until a signal.

    Raises:
        UnavailableError: the port or the database is not to be had.
        whatever ended the factory.
    """
    service, token = with_admin_token(service)
    settings = service.settings
    prepare_logs(settings)
    with contextlib.ExitStack() as stack:
        listener = stack.enter_context(contextlib.closing(listen(settings.host, settings.port)))
        port = listener.getsockname()[1]
        stops = stack.enter_context(contextlib.closing(listen_for_stops(settings, port)))
        service = with_stop_port(service, stops)
        store = await open_store(settings.database_url)
        try:
            incarnation = await store.next_incarnation(service.plant.id)
            authority = await authority_of(store)
            tracing = stack.enter_context(traced(settings))
            life = _life(service, incarnation, authority.public, tracing)
            factory = SimThread(life, paced(service.speed))
            try:
                inside = await asyncio.to_thread(factory.start, BUILDING_S)
                app = _app(service, store, authority, factory, inside, incarnation, (stops, port))
                url = address_of(listener, settings.host)
                greeting = greeting_of(
                    service, url, token, await welcome(store, service.plant.file, time.time())
                )
                await serve(service, app, listener, greeting, factory.wait)
            finally:
                await asyncio.to_thread(factory.stop)
        finally:
            await store.close()


def with_admin_token(service: Service) -> tuple[Service, str]:
    """The service with a token for its administrator; and the token when it was made here."""
    if service.settings.admin_token is not None:
        return service, ""
    token = new_token()
    settings = service.settings.model_copy(update={"admin_token": SecretStr(token)})
    return replace(service, settings=settings), token


def with_stop_port(service: Service, listener: socket.socket) -> Service:
    """The service with the port that its stops have got: the panels are told."""
    settings = service.settings.model_copy(update={"stop_port": listener.getsockname()[1]})
    return replace(service, settings=settings)


def _life(
    service: Service, incarnation: int, trusted: bytes, tracing: TracerProvider | None
) -> Callable[[Callable[[Inside], None]], Coroutine[None, None, None]]:
    """What the factory's thread runs."""

    async def live(ready: Callable[[Inside], None]) -> None:
        now = clock()

        def to_wall_s(plant_s: float) -> float:
            """The clocks are compared when the factory has been built; nobody speaks before."""
            return scale.to_wall_s(plant_s)

        factory = SimFactory(
            service.plant,
            now,
            seed=service.seed,
            incarnation=incarnation,
            stock_frac=NEARLY_EMPTY_FRAC,
            trusts=TrustedKeys(trusted),
            meet=watched(service.settings, tracing, to_wall_s),
        )
        scale = TimeScale(now.now_s(), time.time(), service.speed)
        ready(Inside(factory, Faults(factory), scale))
        await factory.run()

    return live


def _app(
    service: Service,
    store: Store,
    authority: SigningKey,
    factory: Factory,
    inside: Inside,
    incarnation: int,
    stops: tuple[socket.socket, int],
) -> FastAPI:
    settings, plant = service.settings, service.plant

    @contextlib.contextmanager
    def beside() -> Iterator[Bus]:
        yield BridgedBus(inside.factory.bus, factory.loop, asyncio.get_running_loop())

    bus = BridgedBus(inside.factory.bus, factory.loop, asyncio.get_running_loop())
    historian = historian_of(settings, plant, store, bus, inside.time, incarnation)
    return create_app(
        settings=settings,
        plant=plant.file,
        bus=bus,
        store=store,
        time=inside.time,
        authority=authority,
        incarnation=incarnation,
        historian=historian,
        collectors=(FactoryMeter(inside.factory, bus),),
        faults=SimFaultDesk(inside.faults, factory.loop, time.time),
        beside=StopWay(*stops, settings, beside, authority, inside.time, incarnation).beside,
    )


def historian_of(
    settings: Settings, plant: Plant, store: Store, bus: Bus, scale: TimeScale, life: int
) -> Historian:
    """The historian of a plant, which is not running yet."""
    return Historian(
        store=store,
        bus=bus,
        keys=Keys(plant.id),
        to_wall_s=scale.to_wall_s,
        clocks=Clocks(scale.speed),
        to_plant_s=scale.to_plant_s,
        life=life,
        agents=(*plant.fleet, *plant.machines, *plant.storages, STRATEGIST),
        linger_s=settings.historian_linger_s,
        events_kept=settings.events_kept,
        samples_kept=settings.samples_kept,
    )


async def serve(
    service: Service,
    app: FastAPI,
    listener: socket.socket,
    greeting: str,
    ended: Callable[[], Awaitable[object]] | None = None,
) -> None:
    """Answer until a signal.

    Args:
        service: what runs.
        app: the gateway.
        listener: where it answers.
        greeting: what to say when it does.
        ended: returns or raises when it makes no sense to go on; when a factory ends, say.

    Raises:
        UnavailableError: Prometheus' port is not to be had.
        whatever keeps the gateway from starting.
    """
    ready = asyncio.Event()
    server = Server(app, service.settings, ready.set)
    quieten(service.settings)  # uvicorn has just set its own level
    with stopped_by_signals(server.stop):
        async with _told(service.settings, app), asyncio.TaskGroup() as group:
            tasks = [
                group.create_task(_greet(greeting, ready)),
                group.create_task(_order(service, app, ready)),
            ]
            if ended is not None:
                tasks.append(group.create_task(_stop_with(ended, server)))
            await server.serve(sockets=[listener])
            for task in tasks:
                task.cancel()
    if server.failure is not None:
        raise server.failure


async def _greet(greeting: str, ready: asyncio.Event) -> None:
    await ready.wait()
    typer.echo(greeting, nl=False)
    tell_ready()


def greeting_of(service: Service, url: str, token: str, links: Mapping[str, str]) -> str:
    """What to say when requests are answered.

    Args:
        service: what runs.
        url: where.
        token: the administrator's, if it was made for this run.
        links: per person without a secret, the token of a login link.
    """
    plant, database = service.plant, make_url(service.settings.database_url)
    lines = GREETING.format(
        version=__version__,
        plant=plant.name,
        machines=len(plant.machines),
        vehicles=len(plant.fleet),
        speed=service.speed,
        url=url,
        database=database.render_as_string(hide_password=True),
    )
    if token:
        lines += FOR_ADMIN.format(token=token)
    if links:
        lines += LINKS.format(
            links="\n".join(f"  {person:<16}  {url}/login/{link}" for person, link in links.items()),
            db=_db_option(database),
        )
    return lines + "Ctrl-C stops it.\n"


def _db_option(database: URL) -> str:
    """How other commands find this database; empty where they do by themselves, or need its password, too."""
    if database == make_url(Settings.model_fields["database_url"].default) or database.password is not None:
        return ""
    return f" --db {shlex.quote(database.render_as_string())}"


@contextlib.asynccontextmanager
async def _told(settings: Settings, app: FastAPI) -> AsyncIterator[None]:
    """Tell Prometheus without a login what `/metrics` tells it with one, if that is asked for."""
    if not settings.metrics_listen:
        yield
        return

    async def read() -> Iterable[Metric]:
        parts: Parts = app.state.parts
        await parts.health.examine()
        return parts.metrics.registry.collect()

    async with metrics_port(settings.metrics_listen, read):
        yield


async def _order(service: Service, app: FastAPI, ready: asyncio.Event) -> None:
    await ready.wait()
    if service.demand:
        await place_demand(app.state.parts, service.plant, speed=service.speed, seed=service.seed)


async def _stop_with(ended: Callable[[], Awaitable[object]], server: Server) -> None:
    try:
        await ended()
    finally:
        server.stop()
