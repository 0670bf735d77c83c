"""The stop path on a thread of its own."""

from __future__ import annotations

import asyncio
import contextlib
import http.client
import json
import threading
from collections.abc import AsyncIterator, Iterator
from pathlib import Path
from typing import Any

import pytest

from dray.adapters.crossing import Crossing
from dray.adapters.security.signing import SigningKey
from dray.cli.runtime.gateway import stop_path
from dray.cli.runtime.gateway.stop_path import StopPath, listen_for_stops
from dray.cli.runtime.listener import listen
from dray.gateway.app import create_app
from dray.gateway.http.provided import provided
from dray.gateway.live.projection import Projection
from dray.gateway.live.timescale import TimeScale
from dray.gateway.stop.endpoint import StopEndpoint
from dray.messages import CommandAnswered, Message, VehicleCommand
from dray.plant import default_plant
from dray.ports import Receive
from dray.settings import Settings
from dray.store import Store, open_store

pytestmark = pytest.mark.anyio

LONG_S = 60.0
"""Nothing in a test takes so long."""


class Bus:
    """A bus on which every vehicle obeys, with the next turn of the loop."""

    context = ""

    def __init__(self) -> None:
        self._receive: Receive = lambda _sender, _message: None

    def join(self, _agent: str, receive: Receive, _life: int = 0) -> Bus:
        self._receive = receive
        return self

    def send(self, to: str, message: Message) -> None:
        if isinstance(message, VehicleCommand):
            answer = CommandAnswered(command=message.command, done=True)
            asyncio.get_running_loop().call_soon(self._receive, to, answer)

    def publish(self, key: str, message: Message) -> None:
        """Nobody listens."""

    def subscribe(self, key: str) -> None:
        """Nobody speaks."""

    def unsubscribe(self, key: str) -> None:
        """Nobody speaks."""

    def leave(self) -> None:
        """Nobody notices."""


@contextlib.asynccontextmanager
async def running(folder: Path) -> AsyncIterator[tuple[int, Projection, Store]]:
    """A gateway whose stop path is open; its port."""
    settings = Settings.load(
        database_url=f"sqlite:///{folder / 'stop.db'}", admin_token="secret", port=0, stop_port=None
    )
    plant, authority, time = default_plant(), SigningKey(bytes(32)), TimeScale(0.0, 0.0)

    @contextlib.contextmanager
    def bus() -> Iterator[Bus]:
        yield Bus()

    store = await open_store(settings.database_url)
    with contextlib.closing(listen_for_stops(settings, 8000)) as listener:
        way = StopPath(listener, 8000, settings, bus, authority, time, 1)
        app = create_app(
            settings=settings,
            plant=plant.file,
            bus=Bus(),
            store=store,
            time=time,
            authority=authority,
            beside=way.beside,
        )
        async with app.router.lifespan_context(app):
            yield listener.getsockname()[1], provided(app, Projection), store
    await store.close()


def stop(port: int) -> tuple[int, Any]:
    """Ask for a stop, and wait for its answer."""
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=LONG_S)
    with contextlib.closing(connection):
        headers = {"Authorization": "Bearer secret", "Content-Type": "application/json"}
        connection.request("POST", "/api/atvs/ATV1/commands", json.dumps({"kind": "stop"}), headers)
        answer = connection.getresponse()
        return answer.status, json.loads(answer.read())


async def test_a_stop_passes_while_the_gateways_own_loop_is_held(tmp_path: Path) -> None:
    async with running(tmp_path) as (port, projection, _):
        answers: list[tuple[int, Any]] = []
        asking = threading.Thread(target=lambda: answers.append(stop(port)))
        asking.start()
        # Nothing on this loop goes on before the answer is there.
        asking.join(LONG_S)
        assert [status for status, _ in answers] == [200]
        assert answers[0][1]["done"] is True
        assert projection.commands.views() == ()
        # What was done is known here with the loop's next turn.
        await asyncio.sleep(0)
        (shown,) = projection.commands.views()
        assert (shown.atv, shown.kind, shown.by) == ("ATV1", "stop", "Administrator")


async def test_the_gateways_thread_is_woken_only_when_the_stop_and_its_answer_have_left(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    done: list[str] = []

    class Watched(Crossing):
        def order(self, call: Any, *args: Any) -> None:
            done.append("the gateway is told")
            super().order(call, *args)

    send, answer = Bus.send, StopEndpoint.__call__

    def sent(bus: Bus, to: str, message: Message) -> None:
        if isinstance(message, VehicleCommand):
            done.append("the vehicle is told")
        send(bus, to, message)

    async def answered(endpoint: StopEndpoint, *asgi: Any) -> None:
        await answer(endpoint, *asgi)
        done.append("answered")

    monkeypatch.setattr(stop_path, "Crossing", Watched)
    monkeypatch.setattr(Bus, "send", sent)
    monkeypatch.setattr(StopEndpoint, "__call__", answered)
    async with running(tmp_path) as (port, _, _):
        status, _ = await asyncio.to_thread(stop, port)
        assert status == 200
    assert done == ["the vehicle is told", "the gateway is told", "answered", "the gateway is told"]


async def test_the_port_for_stops_is_the_next_one_or_any_that_is_free(
    caplog: pytest.LogCaptureFixture,
) -> None:
    with contextlib.closing(listen("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        with contextlib.closing(listen_for_stops(Settings.load(port=port - 1), port - 1)) as listener:
            assert listener.getsockname()[1] not in {port, 0}
        assert "DRAY_STOP_PORT names one for good" in caplog.text
        named = Settings.load(stop_port=port)
        with pytest.raises(Exception, match="DRAY_STOP_PORT"):
            listen_for_stops(named, port - 1)
