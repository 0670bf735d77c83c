"""A gateway's service: its address, its greeting, its administrator's token, and answering until a signal."""

from __future__ import annotations

import asyncio
import contextlib
import gc
import shlex
import socket
from collections.abc import AsyncIterator, Awaitable, Callable, Iterable, Mapping
from dataclasses import dataclass, replace

import typer
from fastapi import FastAPI
from prometheus_client import Metric
from pydantic import SecretStr
from sqlalchemy import URL, make_url

from dray import __version__
from dray.adapters.telemetry.metrics_port import metrics_port
from dray.cli.runtime.gateway.serving import Server
from dray.cli.runtime.readiness import tell_ready
from dray.cli.runtime.signals import stopped_by_signals
from dray.cli.runtime.telemetry.logs import quieten
from dray.gateway.access.tokens import new_token
from dray.gateway.http.provided import provided
from dray.gateway.live.health import Health
from dray.gateway.live.timescale import TimeScale
from dray.gateway.metrics import Metrics
from dray.gateway.orders.placement import OrderPlacement
from dray.messages.keys import GATE, Keys, strategists_of
from dray.plant import Plant
from dray.ports import Bus
from dray.settings import Settings
from dray.store import Historian, Store
from dray.store.history.clocks import Clocks
from dray.store.retention import DAY_S, KeptFor, Retention

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


Customers = Callable[[OrderPlacement], Awaitable[None]]
"""Whoever orders at a gateway of this process."""


@dataclass(frozen=True, slots=True)
class Service:
    """What is to be run.

    Attributes:
        settings: the gateway's.
        plant: the factory's.
        speed: factory seconds per real second.
        customers: place orders from when requests are answered until cancelled; None where nobody simulates any.
        greets: whether it says where it answers, and by which links people come in.
    """

    settings: Settings
    plant: Plant
    speed: float
    customers: Customers | None = None
    greets: bool = True


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


def historian_of(
    settings: Settings,
    plant: Plant,
    store: Store,
    bus: Bus,
    scale: TimeScale,
    life: int,
    wall_s: Callable[[], float],
) -> Historian:
    """The historian of a plant, which is not running yet. Call it on the loop on which it will run."""
    return Historian(
        store=store,
        bus=bus,
        keys=Keys(plant.id),
        to_wall_s=scale.to_wall_s,
        clocks=Clocks(scale.speed),
        to_plant_s=scale.to_plant_s,
        life=life,
        agents=(*plant.fleet, *plant.machines, *plant.stores, GATE, *strategists_of(settings.strategists)),
        linger_s=settings.historian_linger_s,
        wall_s=wall_s,
        retention=Retention(store, _kept_for(settings), wall_s),
    )


def _kept_for(settings: Settings) -> KeptFor:
    return KeptFor(
        events_s=settings.events_days * DAY_S,
        samples_s=settings.samples_days * DAY_S,
        figures_s=settings.figures_days * DAY_S,
        tasks_s=settings.tasks_days * DAY_S,
        transports_s=settings.transports_days * DAY_S,
        alerts_s=settings.alerts_days * DAY_S,
        audit_s=settings.audit_days * DAY_S,
        events_most=settings.events_most,
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
                group.create_task(_greet(greeting if service.greets else "", ready)),
                group.create_task(_order(service, app, ready)),
            ]
            if ended is not None:
                tasks.append(group.create_task(_stop_with(ended, server)))
            await server.serve(sockets=[listener])
            for task in tasks:
                task.cancel()
    gc.unfreeze()
    if server.failure is not None:
        raise server.failure


async def _greet(greeting: str, ready: asyncio.Event) -> None:
    await ready.wait()
    # What was loaded for a start stays: a full collection looks at what has come since, and holds the loop up for no tenth of a second.
    gc.collect()
    gc.freeze()
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
        await provided(app, Health).examine()
        return provided(app, Metrics).registry.collect()

    async with metrics_port(settings.metrics_listen, read):
        yield


async def _order(service: Service, app: FastAPI, ready: asyncio.Event) -> None:
    await ready.wait()
    if service.customers is not None:
        await service.customers(provided(app, OrderPlacement))


async def _stop_with(ended: Callable[[], Awaitable[object]], server: Server) -> None:
    try:
        await ended()
    finally:
        server.stop()
