"""A gateway without a factory: a bus on which the test speaks for the agents, a file, and a client.

Nothing here waits for time to pass: the bus delivers at once, the wall clock is the test's, and what has
been sent can be awaited.
"""

from __future__ import annotations

from collections.abc import AsyncIterator, Callable, Iterable
from contextlib import asynccontextmanager
from dataclasses import dataclass
from functools import cache
from typing import Any, cast

import httpx
from argon2 import PasswordHasher
from fake_bus import KEYS, PLANT, FakeBus
from fastapi import FastAPI
from prometheus_client.registry import Collector
from wall_clock import NOW_S, Wall

from dray.adapters.security.signing import SigningKey
from dray.cli.runtime.gateway.operators import OperatorWorkers
from dray.gateway.access.access import Access
from dray.gateway.access.login.hasher import Hasher
from dray.gateway.access.principal import Role, Scope
from dray.gateway.access.tokens import new_id, new_key
from dray.gateway.app import create_app
from dray.gateway.factory.alerts import AlertMonitor
from dray.gateway.factory.commands import Commands
from dray.gateway.factory.exclusions import Exclusions
from dray.gateway.factory.fault_injection import FaultInjector
from dray.gateway.factory.scenario_play import ScenarioPlayer
from dray.gateway.http.assets import Panels
from dray.gateway.http.provided import provided
from dray.gateway.live.peer import Peer
from dray.gateway.live.projection import Projection
from dray.gateway.live.replay.recorder import Recorder
from dray.gateway.live.stream import Hub
from dray.gateway.live.timescale import TimeScale
from dray.gateway.orders.completions import Completions
from dray.gateway.orders.outbox import Outbox
from dray.gateway.orders.placement import OrderPlacement
from dray.messages import Message
from dray.plant import PlantFile
from dray.settings import Settings
from dray.store import Historian, Store
from dray.store.access.api_keys import ApiKey
from dray.store.access.audit import AuditFilter, AuditRow
from dray.store.access.people import Person
from dray.store.database.database import Database
from dray.store.orders.order_filter import EVERY_ORDER
from dray.store.retention import KeptFor, Retention
from dray.supervision import Supervisor

PRODUCT, OTHER_PRODUCT = "gear-unit-g1", "pump-p3"
"""Two that the default plant makes."""


AUTHORITY = SigningKey(bytes(32))
"""Grants commands in every gateway of these tests."""


ADMIN_TOKEN = "admin-token-of-these-tests"

STREAM = "/api/stream"
"""Where the websocket is."""

BEARER = {"Authorization": f"Bearer {ADMIN_TOKEN}"}


QUICK = Hasher(PasswordHasher(time_cost=1, memory_cost=8, parallelism=1))
"""As cheap as Argon2 can be."""


PASSWORD, PIN = "four words are good", "402719"
"""A manager's and an operator's."""


SECRETS = {Role.MANAGER: PASSWORD, Role.OPERATOR: PIN}

HOME = "http://dray.test"


NOTHING = KeptFor(
    events_s=-1e9,
    samples_s=-1e9,
    figures_s=-1e9,
    tasks_s=-1e9,
    transports_s=-1e9,
    alerts_s=-1e9,
    audit_s=-1e9,
    events_most=1000,
)
"""Is kept, of whatever age."""


@dataclass
class House:
    """One running gateway, and everything around it."""

    app: FastAPI
    bus: FakeBus
    client: httpx.AsyncClient
    store: Store
    historian: Historian
    wall: Wall

    @property
    def projection(self) -> Projection:
        return provided(self.app, Projection)

    @property
    def outbox(self) -> Outbox:
        return provided(self.app, Outbox)

    @property
    def completions(self) -> Completions:
        return provided(self.app, Completions)

    @property
    def placement(self) -> OrderPlacement:
        return provided(self.app, OrderPlacement)

    @property
    def commands(self) -> Commands:
        return provided(self.app, Commands)

    @property
    def alerts(self) -> AlertMonitor:
        return provided(self.app, AlertMonitor)

    @property
    def exclusions(self) -> Exclusions:
        return provided(self.app, Exclusions)

    @property
    def hub(self) -> Hub:
        return provided(self.app, Hub)

    @property
    def recorder(self) -> Recorder:
        return provided(self.app, Recorder)

    @property
    def peer(self) -> Peer:
        return provided(self.app, Peer)

    @property
    def access(self) -> Access:
        return provided(self.app, Access)

    async def get(self, path: str, **params: Any) -> Any:
        """The body of an answer that is 200."""
        response = await self.client.get(path, params=params)
        assert response.status_code == 200, response.text
        return response.json()

    async def place(self, **fields: Any) -> dict[str, Any]:
        """Place an order that can be taken; `fields` may change anything."""
        response = await self.client.post("/api/orders", json=draft(**fields))
        assert response.status_code == 201, response.text
        return cast(dict[str, Any], response.json())

    async def know(self, who: str, role: Role = Role.MANAGER, *areas: str) -> Person:
        """Somebody who may log in: a manager by `PASSWORD`, an operator by `PIN`."""
        secret = {"password_hash" if role is Role.MANAGER else "pin_hash": QUICK.hash(SECRETS[role])}
        person = Person(id=who, name=who.title(), role=role, created_at_s=NOW_S, areas=areas, **secret)
        async with self.store.write() as work:
            await work.people.add(person)
        return person

    def visitor(self, **headers: str) -> httpx.AsyncClient:
        """A browser of somebody who has not logged in yet."""
        return httpx.AsyncClient(transport=self.client._transport, base_url=HOME, headers=headers)

    async def log_in(self, who: str, role: Role = Role.MANAGER, *areas: str) -> httpx.AsyncClient:
        """The browser of somebody new who has logged in."""
        person = await self.know(who, role, *areas)
        browser = self.visitor()
        answer = await browser.post("/login", data={"name": who, "secret": SECRETS[Role(person.role)]})
        assert answer.status_code == 303, answer.text
        return browser

    async def key(self, *scopes: Scope, **fields: Any) -> tuple[ApiKey, dict[str, str]]:
        """A new key of another system, and the header that shows it."""
        token = new_key()
        named = {"name": "ERP"} | fields
        key = ApiKey(id=new_id(), scopes=" ".join(scopes), created_at_s=NOW_S, **named)
        async with self.store.write() as work:
            await work.api_keys.add(token, key)
        return key, {"Authorization": f"Bearer {token}"}

    async def audit(self, **wanted: Any) -> list[AuditRow]:
        """The lines of the audit log, newest first; all of them, also those that were to be written later."""
        await self.access.audit_log.catch_up()
        async with self.store.read() as work:
            return await work.audit.page(AuditFilter(**wanted), None, 100)

    async def orders_kept(self) -> int:
        """How many orders are on disk."""
        async with self.store.read() as work:
            return len(await work.orders.page(EVERY_ORDER, None, None))

    async def forget_everything(self) -> None:
        """Everything is too old, as `Retention` sees it."""
        await Retention(self.store, NOTHING, self.wall).forget()
        assert (await self.get("/api/events"))["items"] == []

    async def say(self, messages: Iterable[Message]) -> None:
        """Publish these, and wait until the historian has written them."""
        self.bus.say(*messages)
        await self.historian.written()


def draft(**fields: Any) -> dict[str, Any]:
    """A body of `POST /api/orders` that can be taken; `fields` may change anything."""
    return {"customer": "Muster GmbH", "items": [{"product": PRODUCT, "quantity": 5}]} | fields


USUAL = {"admin_token": ADMIN_TOKEN, "allowed_hosts": "dray.test"}


@cache
def usual_settings() -> Settings:
    """What most gateways here are told; loading it takes a tenth of a start."""
    return Settings.load(**USUAL)


@asynccontextmanager
async def gateway(
    url: str,
    *,
    plant: PlantFile = PLANT,
    bus: FakeBus | None = None,
    wall: Wall | None = None,
    speed: float = 1.0,
    incarnation: int = 1,
    panels: Panels | None = None,
    faults: FaultInjector | None = None,
    scenario: ScenarioPlayer | None = None,
    collectors: Iterable[Collector] = (),
    change: Callable[[FastAPI], None] = lambda _app: None,
    duty: bool = False,
    fails: bool = False,
    **settings: Any,
) -> AsyncIterator[House]:
    """Run a gateway on the database at `url`; the plant's clock is 0 at `NOW_S`, its client the administrator.

    Args:
        url: of a database that has all tables, as `Files` and `Postgres` make them.
        plant: what the gateway is told to stand in.
        bus: where others have joined already; a new one when absent.
        wall: the wall clock; one that stands at `NOW_S` when absent.
        speed: plant seconds per wall second.
        incarnation: of the plant's agents.
        panels: templates and built files, when not the package's own.
        faults: the injector of a simulated factory.
        scenario: the player of a simulated factory.
        collectors: of metrics beside the gateway's own.
        change: something to do to the application before it starts.
        duty: whether people can be on duty.
        fails: whether tasks of the gateway are to fail; else that is an error of the test's.
        settings: fields of `Settings` that differ from the defaults.
    """
    bus, wall = bus or FakeBus(), wall or Wall()
    time = TimeScale(0.0, NOW_S, speed)
    store = Store(await Database.open(url))
    try:
        historian = Historian(
            store=store, bus=bus, keys=KEYS, to_wall_s=time.to_wall_s, wall_s=wall, linger_s=0
        )
        operators = OperatorWorkers(bus, KEYS, time, wall) if duty else None
        app = create_app(
            settings=(
                Settings.load(**USUAL | settings, database_url=url)
                if settings
                else usual_settings().model_copy(update={"database_url": url})
            ),
            plant=plant,
            bus=bus,
            store=store,
            time=time,
            authority=AUTHORITY,
            incarnation=incarnation,
            historian=historian,
            panels=panels,
            faults=faults,
            scenario=scenario,
            collectors=collectors,
            wall_s=wall,
            hasher=QUICK,
            operators=operators,
        )
        change(app)
        transport = httpx.ASGITransport(app=app, raise_app_exceptions=False)
        async with (
            app.router.lifespan_context(app),
            httpx.AsyncClient(transport=transport, base_url=HOME, headers=BEARER) as client,
        ):
            yield House(app, bus, client, store, historian, wall)
        restarts = provided(app, Supervisor).restarts + historian.supervisor.restarts
        assert not restarts or fails, f"tasks have failed, and the log has the reason: {restarts}"
    finally:
        await store.close()
