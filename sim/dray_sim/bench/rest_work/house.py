"""A simulated factory and its gateway in this process, with a script that runs in the factory, and a REST client."""

from __future__ import annotations

import asyncio
import http.client
import json
import signal
import time
from collections.abc import AsyncIterator, Awaitable, Callable, Sequence
from contextlib import asynccontextmanager, closing
from dataclasses import dataclass
from http import HTTPStatus
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Generic, TypeVar

from pydantic import SecretStr

from dray.adapters.addresses import free_addresses
from dray.cli.runtime.gateway.service import Service
from dray.cli.simulation.one_process import run_service
from dray.errors import UnavailableError
from dray.gateway.access.tokens import new_token
from dray.plant import Plant
from dray.settings import Settings
from dray_sim.run.part import Part
from dray_sim.run.stage import Shift, Stage
from dray_sim.scenarios import LivePart

T = TypeVar("T")

HOST = "127.0.0.1"

START_S = 300.0
"""Longest wait for the first answer, on a computer that is busy elsewhere."""

ANSWER_S = 60.0
"""Longest wait for any other."""

WRITTEN_WITHIN_S = 660.0
"""Real seconds until REST shows what the floor has done: a gateway asks for missed events every ten minutes."""

AGAIN_S = 0.5
"""Pause between two looks (s)."""


class Client:
    """A REST client of a gateway.

    Args:
        port: the gateway's.
        headers: that identify the client.
    """

    def __init__(self, port: int, **headers: str) -> None:
        self._port, self._headers = port, {"Content-Type": "application/json", **headers}

    def ask(self, method: str, path: str, body: object = None, **headers: str) -> tuple[int, Any]:
        """Ask once; returns the status and the answer, or 0 and None when nobody answers."""
        sent = None if body is None else json.dumps(body).encode()
        with closing(http.client.HTTPConnection(HOST, self._port, timeout=ANSWER_S)) as connection:
            try:
                connection.request(method, path, sent, {**self._headers, **headers})
                answer = connection.getresponse()
                return answer.status, json.loads(answer.read() or b"null")
            except (OSError, http.client.HTTPException, ValueError):
                return 0, None

    async def get(self, path: str) -> Any:
        """The answer at this path.

        Raises:
            UnavailableError: the status is not 200.
        """
        status, answer = await asyncio.to_thread(self.ask, "GET", path)
        if status != HTTPStatus.OK:
            raise UnavailableError("the gateway", f"answered {path} with {status}: {answer}", "see why")
        return answer

    async def all(self, path: str) -> list[dict[str, Any]]:
        """All pages of a list."""
        found, cursor = [], ""
        while True:
            page = await self.get(f"{path}?limit=100{f'&cursor={cursor}' if cursor else ''}")
            found += page["items"]
            cursor = page["next_cursor"]
            if cursor is None:
                return found


@dataclass
class House(Generic[T]):
    """A factory that is open.

    Attributes:
        port: of its gateway.
        admin: its administrator.
        database_url: of its database.
        result: of the script; done when it has ended.
    """

    port: int
    admin: Client
    database_url: str
    result: asyncio.Future[T]
    now_s: Callable[[], float] = lambda: 0.0
    """The plant's clock; it stands at 0 until the script runs."""


@asynccontextmanager
async def open_house(
    plant: Plant,
    shift: Shift,
    script: Callable[[Stage], Awaitable[T]],
    *,
    speed: float,
    traffic: bool | None,
    seed: int = 1,
) -> AsyncIterator[House[T]]:
    """A factory as `dray up` runs it, as long as the context lasts.

    Args:
        plant: the factory.
        shift: how busy.
        script: is run in the factory, in its own thread.
        speed: factory seconds per real second.
        traffic: whether vehicles drive with right of way; None: as `dray up` does.
        seed: everything that is left to chance in the factory follows from it.

    Raises:
        UnavailableError: it does not start, or its script ends early.
    """
    loop = asyncio.get_running_loop()
    result: asyncio.Future[T] = loop.create_future()

    async def play(stage: Stage) -> T:
        house.now_s = stage.now_s
        try:
            found = await script(stage)
        finally:
            # A broken invariant ends the script.
            if stage.checks.broken is not None:
                loop.call_soon_threadsafe(_fail, result, str(stage.checks.broken))
        loop.call_soon_threadsafe(_tell, result, found)
        return found

    part = Part(shift.name, shift, lambda: plant, play, (), lambda _found: ())
    with TemporaryDirectory(prefix="dray-work-") as folder:
        port, stop_port = (int(each.rpartition(":")[2]) for each in free_addresses(2))
        url, token = f"sqlite:///{Path(folder) / 'dray.db'}", new_token()
        settings = Settings(
            host=HOST, port=port, stop_port=stop_port, database_url=url, admin_token=SecretStr(token)
        )
        if traffic is not None:
            settings = settings.model_copy(update={"traffic": traffic})
        admin = Client(port, Authorization=f"Bearer {token}")
        house = House(port, admin, settings.database_url, result)
        # No link to log in is printed: it would stand among the figures.
        silent = Service(settings, plant, speed, greets=False)
        service = run_service(silent, seed, None, LivePart(part, shift.name))
        running = asyncio.create_task(service)
        running.add_done_callback(lambda _task: _fail(result, "the factory has ended"))
        try:
            await _until_answered(house.admin, running)
        except BaseException:
            running.cancel()
            raise
        try:
            yield house
        finally:
            if not running.done():
                # Like Ctrl-C: the gateway ends by itself.
                signal.raise_signal(signal.SIGTERM)
            await running


async def until_all(
    client: Client, path: str, done: Callable[[Sequence[dict[str, Any]]], bool], within_s: float
) -> bool:
    """Look at a list until it is so; returns whether it was, within so many real seconds."""
    until_s = time.monotonic() + within_s
    while not done(await client.all(path)):
        if time.monotonic() > until_s:
            return False
        await asyncio.sleep(AGAIN_S * 4)
    return True


async def _until_answered(client: Client, running: asyncio.Task[None]) -> None:
    until_s = time.monotonic() + START_S
    while (await asyncio.to_thread(client.ask, "GET", "/api/plant"))[0] != HTTPStatus.OK:
        if running.done() or time.monotonic() > until_s:
            await asyncio.wait({running}, timeout=0)
            raise UnavailableError("dray up", "does not answer", "see why") from (
                running.exception() if running.done() else None
            )
        await asyncio.sleep(AGAIN_S)


def _tell(result: asyncio.Future[T], found: T) -> None:
    if not result.done():
        result.set_result(found)


def _fail(result: asyncio.Future[T], why: str) -> None:
    if not result.done():
        result.set_exception(UnavailableError("the factory", why, "see why"))
