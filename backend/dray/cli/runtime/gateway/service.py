"""A gateway's service: its address, its greeting, its administrator's token, and serving until a signal."""

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
With a secret of their own people need no link: dray user password manager{db}, dray user pin NAME{db}.
"""


Customers = Callable[[OrderPlacement], Awaitable[None]]
"""Customers who order at a gateway of this process."""


@dataclass(frozen=True, slots=True)
class Service:
    """The parameters of a service.

    Attributes:
        settings: the gateway's.
        plant: the factory's.
        speed: factory seconds per real second.
        customers: place orders while requests are served, until cancelled; None for none.
        greets: whether it prints its address and the login links.
    """

    settings: Settings
    plant: Plant
    speed: float
    customers: Customers | None = None
    greets: bool = True


def with_admin_token(service: Service) -> tuple[Service, str]:
    """The service with an administrator's token; and the token if it was created here."""
    if service.settings.admin_token is not None:
        return service, ""
    token = new_token()
    settings = service.settings.model_copy(update={"admin_token": SecretStr(token)})
    return replace(service, settings=settings), token


def with_stop_port(service: Service, listener: socket.socket) -> Service:
    """The service with the actual port for stops, for the panels."""
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
    """A plant's historian that is not running yet. Call it on the loop on which it will run."""
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
    """Serve until a signal.

    Args:
        service: the parameters.
        app: the gateway.
        listener: its port.
        greeting: printed when it serves.
        ended: returns or raises when serving makes no sense any more, as after the end of a simulated factory.

    Raises:
        UnavailableError: Prometheus' port is unavailable.
        Exception: any that keeps the gateway from starting.
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
    # Objects from the start stay: a full collection then only looks at later ones, and does not hold the loop up for a tenth of a second.
    gc.collect()
    gc.freeze()
    typer.echo(greeting, nl=False)
    tell_ready()


async def note_address(service: Service, store: Store, url: str, at_s: float) -> None:
    """Let commands on this database know where its gateway is reached.

    Args:
        service: the parameters.
        store: its database.
        url: the address of its port.
        at_s: wall clock.
    """
    async with store.write() as work:
        await work.addresses.put(service.settings.gateway_name, service.settings.public_url or url, at_s)


def greeting_of(service: Service, url: str, token: str, links: Mapping[str, str]) -> str:
    """The text to print when requests are served.

    Args:
        service: the parameters.
        url: the address.
        token: the administrator's, if it was created for this run.
        links: by person without a secret, the token of a login link.
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
    """The option with which other commands find this database; empty if not needed, or if it would need a password."""
    if database == make_url(Settings.model_fields["database_url"].default) or database.password is not None:
        return ""
    return f" --db {shlex.quote(database.render_as_string())}"


@contextlib.asynccontextmanager
async def _told(settings: Settings, app: FastAPI) -> AsyncIterator[None]:
    """Serve the metrics of `/metrics` to Prometheus without a login, if the settings ask for it."""
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
