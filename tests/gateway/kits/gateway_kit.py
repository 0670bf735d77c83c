"""A gateway without a factory: a bus on which the test speaks for the agents, a file, and a client.

Nothing here waits for time to pass: the bus delivers at once, the wall clock is the test's, and what has
been sent can be awaited.
"""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable, Iterable
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from typing import Any, TypeVar, cast

import httpx
from argon2 import PasswordHasher
from fastapi import FastAPI
from prometheus_client.registry import Collector

from dray.adapters.security.signing import SigningKey
from dray.errors import UnavailableError
from dray.gateway.access.access import Access
from dray.gateway.access.login.hasher import Hasher
from dray.gateway.access.principal import Role, Scope
from dray.gateway.access.tokens import new_id, new_key
from dray.gateway.app import create_app
from dray.gateway.factory.alerts import AlertMonitor
from dray.gateway.factory.commands import Commands
from dray.gateway.factory.exclusions import Exclusions
from dray.gateway.factory.fault_injection import FaultInjector, FaultKind, FaultRefused
from dray.gateway.http.assets import Panels
from dray.gateway.http.provided import provided
from dray.gateway.live.peer import Peer
from dray.gateway.live.projection import Projection
from dray.gateway.live.stream import Hub
from dray.gateway.live.timescale import TimeScale
from dray.gateway.live.views import FaultView
from dray.gateway.orders.completions import Completions
from dray.gateway.orders.outbox import Outbox
from dray.gateway.orders.placement import OrderPlacement
from dray.messages import (
    AtvHeartbeat,
    AtvStatus,
    CommandAnswered,
    Event,
    EventsAsked,
    MachineHeartbeat,
    MachineStatus,
    Message,
    OrderReleased,
    OrderTaken,
    Pose,
    StationHeartbeat,
    VehicleCommand,
)
from dray.messages.fact import AnyFact
from dray.messages.keys import Keys
from dray.plant import PlantFile, default_plant
from dray.ports import Receive
from dray.settings import Settings
from dray.store import Historian, Store
from dray.store.access.api_keys import ApiKey
from dray.store.access.audit import AuditFilter, AuditRow
from dray.store.access.people import Person
from dray.store.database.database import Database
from dray.store.orders.order_filter import EVERY_ORDER

PLANT = default_plant().file
KEYS = Keys(PLANT.plant)

PRODUCT, OTHER_PRODUCT = "gear-unit-g1", "pump-p3"
"""Two that the default plant makes."""

NOW_S = 1_900_000_000.0
"""The wall clock at the start: 17 March 2030."""

PROBLEM = "application/problem+json"

AUTHORITY = SigningKey(bytes(32))
"""Grants commands in every gateway of these tests."""

ADMIN_TOKEN = "admin-token-of-these-tests"

BEARER = {"Authorization": f"Bearer {ADMIN_TOKEN}"}

QUICK = Hasher(PasswordHasher(time_cost=1, memory_cost=8, parallelism=1))
"""As cheap as Argon2 can be."""

M = TypeVar("M", bound=Message)


# --- the bus -------------------------------------------------------------------------------------


def matches(pattern: str, key: str) -> bool:
    """Whether a subscription hears a key: `*` is one chunk, `**` any number, at the end only."""
    wanted, given = pattern.split("/"), key.split("/")
    if wanted[-1] == "**":
        wanted, given = wanted[:-1], given[: len(wanted) - 1]
    return len(wanted) == len(given) and all(w in ("*", g) for w, g in zip(wanted, given, strict=True))


@dataclass
class FakeSession:
    """One agent's place on the fake bus."""

    bus: FakeBus
    agent: str
    receive: Receive
    keys: set[str] = field(default_factory=set)

    def publish(self, key: str, message: Message) -> None:
        for session in list(self.bus.sessions.values()):
            if any(matches(pattern, key) for pattern in session.keys):
                session.receive(self.agent, message)

    def send(self, to: str, message: Message) -> None:
        # The gateway's questions whether the strategist is there come at any time.
        if not isinstance(message, EventsAsked) or to != "strategist":
            self.bus.note(self.agent, to, message)
        if to in self.bus.sessions:
            self.bus.sessions[to].receive(self.agent, message)

    def subscribe(self, key: str) -> None:
        self.keys.add(key)

    def unsubscribe(self, key: str) -> None:
        self.keys.discard(key)

    def leave(self) -> None:
        if self.bus.sessions.get(self.agent) is self:
            del self.bus.sessions[self.agent]


class FakeBus:
    """A bus that delivers at once, and remembers what was said to one agent alone."""

    def __init__(self) -> None:
        self.sessions: dict[str, FakeSession] = {}
        self.sent: list[tuple[str, str, Message]] = []
        """Sender, receiver and message, in the order sent; the receiver need not exist."""
        self._more = asyncio.Event()

    def join(self, agent: str, receive: Receive, life: int = 0) -> FakeSession:
        session = self.sessions[agent] = FakeSession(self, agent, receive)
        return session

    def note(self, sender: str, to: str, message: Message) -> None:
        self.sent.append((sender, to, message))
        self._more.set()

    def sent_to(self, to: str, kind: type[M]) -> list[M]:
        """All messages of one kind to one agent so far."""
        return [message for _, there, message in self.sent if there == to and isinstance(message, kind)]

    async def next_to(self, to: str, kind: type[M], after: int = 0) -> M:
        """The message of one kind to one agent that comes after the first `after` ones, once it is sent."""
        while len(self.sent_to(to, kind)) <= after:
            self._more.clear()
            await self._more.wait()
        return self.sent_to(to, kind)[after]

    def say(self, *messages: Message) -> None:
        """Publish heartbeats and events as the agents that they name."""
        for message in messages:
            key, agent = _place(message)
            FakeSession(self, agent, _deaf).publish(key, message)

    def tell(self, sender: str, to: str, message: Message) -> None:
        """Say something to one agent alone."""
        FakeSession(self, sender, _deaf).send(to, message)

    def strategist(self) -> list[OrderReleased]:
        """Let a strategist join that takes every order; the orders that it will have been given."""
        given: list[OrderReleased] = []

        def receive(sender: str, message: Message) -> None:
            if isinstance(message, OrderReleased):
                given.append(message)
                self.tell("strategist", sender, OrderTaken(order=message.order))

        self.join("strategist", receive)
        return given


def _deaf(_sender: str, _message: Message) -> None:
    """Hears nothing."""


def _place(message: Message) -> tuple[str, str]:
    match message:
        case AtvHeartbeat(atv=agent):
            return KEYS.atv_heartbeat(agent), agent
        case MachineHeartbeat(machine=agent):
            return KEYS.machine_heartbeat(agent), agent
        case StationHeartbeat(station=agent):
            return KEYS.station_heartbeat(agent), agent
        case Event(agent=agent):
            return KEYS.events(agent), agent
        case _:
            raise AssertionError(f"nobody publishes {message}")


# --- what agents say -----------------------------------------------------------------------------


def atv_heartbeat(atv: str = "ATV1", seq: int = 1, **fields: Any) -> AtvHeartbeat:
    """A vehicle that stands somewhere; `fields` may change anything."""
    usual: dict[str, Any] = {
        "incarnation": 1,
        "at_s": float(seq),
        "status": AtvStatus.IDLE,
        "pose": Pose(1.0, 2.0, 0.0),
        "node": "n1",
        "speed_mps": 0.0,
        "battery_frac": 0.8,
    }
    return AtvHeartbeat(atv=atv, seq=seq, **usual | fields)


def machine_heartbeat(machine: str = "M1", seq: int = 1, **fields: Any) -> MachineHeartbeat:
    """A machine with nothing to do; `fields` may change anything."""
    usual: dict[str, Any] = {"incarnation": 1, "at_s": float(seq), "status": MachineStatus.IDLE}
    return MachineHeartbeat(machine=machine, seq=seq, **usual | fields)


def station_heartbeat(station: str = "S1", seq: int = 1, **fields: Any) -> StationHeartbeat:
    """The station of a storage, which tells nothing of what lies there; `fields` may change anything."""
    usual: dict[str, Any] = {"incarnation": 1, "at_s": float(seq)}
    return StationHeartbeat(station=station, seq=seq, **usual | fields)


def events(agent: str, *facts: AnyFact, life: int = 1, first: int = 1, at_s: float = 100.0) -> list[Event]:
    """An agent's numbered facts, one second apart."""
    return [
        Event(agent=agent, incarnation=life, number=number, at_s=at_s + number, fact=fact)
        for number, fact in enumerate(facts, first)
    ]


# --- faults by hand --------------------------------------------------------------------------------


class FakeInjector:
    """A fault injector without a factory: it knows the agent ATV3 only."""

    kinds = (FaultKind("powered_off", "Switched off.", ("agent",)),)

    def __init__(self) -> None:
        self.begun: list[dict[str, Any]] = []
        self.ended: list[str] = []
        self.away = False
        """Whether the factory does not answer."""

    async def begin(self, fault: dict[str, Any]) -> FaultView:
        self._answer()
        if fault.get("agent") != "ATV3":
            raise FaultRefused("agent", "there is no such agent")
        self.begun.append(fault)
        name = f"f{len(self.begun)}"
        return FaultView(id=name, kind=fault["kind"], fault=fault, agents=("ATV3",), began_at_s=NOW_S)

    async def end(self, fault: str) -> None:
        self._answer()
        self.ended.append(fault)

    def _answer(self) -> None:
        if self.away:
            raise UnavailableError("the simulated factory", "does not answer", "look at the log")


# --- the gateway ---------------------------------------------------------------------------------


@dataclass
class Wall:
    """A wall clock that goes when it is told to."""

    now_s: float = NOW_S

    def __call__(self) -> float:
        return self.now_s


PASSWORD, PIN = "four words are good", "402719"
"""A manager's and an operator's."""


SECRETS = {Role.MANAGER: PASSWORD, Role.OPERATOR: PIN}

HOME = "http://dray.test"


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
        key = ApiKey(id=new_id(), name="ERP", scopes=" ".join(scopes), created_at_s=NOW_S, **fields)
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

    async def say(self, messages: Iterable[Message]) -> None:
        """Publish these, and wait until the historian has written them."""
        self.bus.say(*messages)
        await self.historian.written()


def draft(**fields: Any) -> dict[str, Any]:
    """A body of `POST /api/orders` that can be taken; `fields` may change anything."""
    return {"customer": "Muster GmbH", "items": [{"product": PRODUCT, "quantity": 5}]} | fields


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
    collectors: Iterable[Collector] = (),
    change: Callable[[FastAPI], None] = lambda _app: None,
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
        collectors: of metrics beside the gateway's own.
        change: something to do to the application before it starts.
        settings: fields of `Settings` that differ from the defaults.
    """
    bus, wall = bus or FakeBus(), wall or Wall()
    time = TimeScale(0.0, NOW_S, speed)
    store = Store(await Database.open(url))
    try:
        historian = Historian(
            store=store, bus=bus, keys=KEYS, to_wall_s=time.to_wall_s, wall_s=wall, linger_s=0
        )
        app = create_app(
            settings=Settings.load(
                **{"database_url": url, "admin_token": ADMIN_TOKEN, "allowed_hosts": "dray.test"} | settings
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
            collectors=collectors,
            wall_s=wall,
            hasher=QUICK,
        )
        change(app)
        transport = httpx.ASGITransport(app=app, raise_app_exceptions=False)
        async with (
            app.router.lifespan_context(app),
            httpx.AsyncClient(transport=transport, base_url=HOME, headers=BEARER) as client,
        ):
            yield House(app, bus, client, store, historian, wall)
    finally:
        await store.close()


# --- reading answers -----------------------------------------------------------------------------


def problem(response: httpx.Response, status: int, kind: str) -> dict[str, Any]:
    """The body of a problem, which says what is wrong, where, and what to do."""
    assert response.status_code == status, response.text
    assert response.headers["content-type"] == PROBLEM
    body = cast(dict[str, Any], response.json())
    assert set(body) <= {"type", "title", "status", "detail", "instance", "errors"}
    assert body["type"] == f"urn:dray:problem:{kind}"
    assert body["status"] == status
    assert body["title"]
    assert body["detail"]
    assert body["instance"] == response.request.url.path
    for error in body.get("errors", ()):
        assert set(error) == {"field", "reason"}
        assert error["field"]
        assert error["reason"]
    return body


def vehicle(house: House, atv: str = "ATV1", *, done: bool = True, reason: str = "") -> list[VehicleCommand]:
    """Let a vehicle join that answers every command; the commands that it will have heard."""
    heard: list[VehicleCommand] = []

    def receive(sender: str, message: Message) -> None:
        if isinstance(message, VehicleCommand):
            heard.append(message)
            house.bus.tell(atv, sender, CommandAnswered(command=message.command, done=done, reason=reason))

    house.bus.join(atv, receive)
    return heard
