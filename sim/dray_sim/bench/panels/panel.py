"""A panel's server for the benchmarks: the whole gateway, fed by a crowd instead of by agents.

It runs on a thread of its own, in real time; the benchmarks measure the browser's own work.
"""

from __future__ import annotations

import asyncio
import threading
import time
from collections.abc import Iterator
from concurrent.futures import Future
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from socket import create_server
from tempfile import TemporaryDirectory

import uvicorn

from dray.adapters.security.signing import SigningKey
from dray.gateway.access.access import Access
from dray.gateway.access.principal import Role
from dray.gateway.access.tokens import new_token
from dray.gateway.app import create_app
from dray.gateway.http.provided import provided
from dray.gateway.live.projection import Projection
from dray.gateway.live.timescale import TimeScale
from dray.messages import Message
from dray.ports import Receive, Session
from dray.settings import Settings
from dray.store import Store, open_store
from dray.store.access.people import Person
from dray_sim.bench.panels.crowd import Crowd

TICK_S = 0.05
"""The crowd is asked for news twice as often as the gateway makes frames."""

OPEN_S, CLOSE_S = 60.0, 20.0
"""Longest waits: ten times what a slow machine takes."""


@dataclass(frozen=True, slots=True)
class House:
    """A gateway that is open.

    Attributes:
        url: its address, without a slash at the end.
        admin_token: opens the whole API.
        session: of a logged-in manager.
        operators: session of a logged-in operator of one area.
    """

    url: str
    admin_token: str
    session: str
    operators: str


class _Nobody:
    """A bus without agents: the crowd's messages go into the projection directly."""

    context = ""

    def join(self, agent: str, receive: Receive, life: int = 0) -> Session:
        return self

    def publish(self, key: str, message: Message) -> None:
        """Do nothing: nobody listens."""

    def send(self, to: str, message: Message) -> None:
        """Do nothing: nobody listens."""

    def subscribe(self, key: str) -> None:
        """Do nothing: nobody publishes."""

    def unsubscribe(self, key: str) -> None:
        """Do nothing: nobody publishes."""

    def leave(self) -> None:
        """Do nothing: nobody listens."""


@contextmanager
def serving(crowd: Crowd) -> Iterator[House]:
    """A gateway that shows this crowd.

    Args:
        crowd: which drives from now on.
    """
    opened: Future[tuple[House, uvicorn.Server]] = Future()

    def run() -> None:
        try:
            with TemporaryDirectory() as folder:
                asyncio.run(_serve(crowd, Path(folder), opened))
        except BaseException as error:
            if opened.done():
                raise
            opened.set_exception(error)

    thread = threading.Thread(target=run, name="panel", daemon=True)
    thread.start()
    house, server = opened.result(OPEN_S)
    try:
        yield house
    finally:
        server.should_exit = True
        thread.join(CLOSE_S)


async def _serve(crowd: Crowd, folder: Path, opened: Future[tuple[House, uvicorn.Server]]) -> None:
    admin_token = new_token()
    settings = Settings.load(database_url=f"sqlite:///{folder / 'bench.db'}", admin_token=admin_token)
    store = await open_store(settings.database_url)
    try:
        app = create_app(
            settings=settings,
            plant=crowd.plant.file,
            bus=_Nobody(),
            store=store,
            time=TimeScale(0.0, time.time(), 1.0),
            authority=SigningKey(SigningKey.generate()),
        )
        with create_server(("127.0.0.1", 0)) as listener:
            async with app.router.lifespan_context(app):
                server = uvicorn.Server(uvicorn.Config(app, lifespan="off", log_level="error"))
                url = f"http://127.0.0.1:{listener.getsockname()[1]}"
                access = provided(app, Access)
                area = crowd.plant.file.areas[0].id
                house = House(
                    url,
                    admin_token,
                    await _logged_in(store, access, "manager", Role.MANAGER),
                    await _logged_in(store, access, "operator", Role.OPERATOR, area),
                )
                driving = asyncio.create_task(_drive(crowd, provided(app, Projection)))
                opened.set_result((house, server))
                await server.serve(sockets=[listener])
                driving.cancel()
    finally:
        await store.close()


async def _logged_in(store: Store, access: Access, name: str, role: Role, *areas: str) -> str:
    """The session of somebody new."""
    person = Person(id=name, name=name.capitalize(), role=role, areas=areas, created_at_s=access.wall_s())
    async with store.write() as work:
        await work.people.add(person)
    token, _ = await access.sessions.begin(person)
    return token


async def _drive(crowd: Crowd, projection: Projection) -> None:
    """Feed the crowd's messages to the gateway in real time."""
    for message in crowd.transports():
        projection.fold(message)
    begun_s = time.monotonic()
    while True:
        for message in crowd.until(time.monotonic() - begun_s):
            projection.fold(message)
        await asyncio.sleep(TICK_S)
