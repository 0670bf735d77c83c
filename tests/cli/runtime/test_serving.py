"""How a process ends: asked to shut down gracefully first, and made to when that is not enough."""

from __future__ import annotations

import asyncio
import contextlib
import gc
import logging
import signal
from collections.abc import AsyncIterator

import pytest
from fastapi import FastAPI

from dray.cli.runtime.gateway.service import Service, _greet, greeting_of
from dray.cli.runtime.gateway.serving import Server
from dray.cli.runtime.listener import listen
from dray.cli.runtime.signals import asked_by_signals
from dray.errors import UnavailableError
from dray.plant import default_plant
from dray.settings import Settings

LONG_S = 600.0
"""Nothing in a test takes so long."""


def ends(*signals: signal.Signals, within_s: float = LONG_S) -> list[str]:
    """What an agent is told, one signal after the other; without any time to leave, until it is stopped."""
    told: list[str] = []

    async def main() -> None:
        heard: asyncio.Queue[str] = asyncio.Queue()

        def leave() -> None:
            heard.put_nowait("leave")

        def stop() -> None:
            heard.put_nowait("stop")

        with asked_by_signals(leave, stop, within_s):
            for each in signals:
                signal.raise_signal(each)
                told.append(await heard.get())
            if not within_s:
                told.append(await heard.get())

    asyncio.run(main())
    return told


def test_a_sigterm_asks_it_to_leave_and_a_second_one_stops_it() -> None:
    assert ends(signal.SIGTERM) == ["leave"]
    assert ends(signal.SIGTERM, signal.SIGTERM) == ["leave", "stop"]


def test_ctrl_c_stops_it_at_once_also_while_it_leaves() -> None:
    assert ends(signal.SIGINT) == ["stop"]
    assert ends(signal.SIGTERM, signal.SIGINT) == ["leave", "stop"]


def test_when_its_time_is_over_it_is_stopped() -> None:
    assert ends(signal.SIGTERM, within_s=0.0) == ["leave", "stop"]


@pytest.mark.parametrize("signals", [(), (signal.SIGTERM,), (signal.SIGINT,)])
def test_afterwards_signals_are_what_they_were(signals: tuple[signal.Signals, ...]) -> None:
    before = [signal.getsignal(each) for each in (signal.SIGINT, signal.SIGTERM)]
    ends(*signals)
    assert [signal.getsignal(each) for each in (signal.SIGINT, signal.SIGTERM)] == before


def test_once_it_is_ready_a_full_collection_looks_at_nothing_that_was_loaded_before() -> None:
    async def main() -> None:
        ready = asyncio.Event()
        ready.set()
        await _greet("", ready)

    try:
        asyncio.run(main())
        assert gc.get_freeze_count() > 10 * len(gc.get_objects())
    finally:
        gc.unfreeze()


def test_an_application_that_cannot_start_tells_why_and_no_traceback(
    caplog: pytest.LogCaptureFixture,
) -> None:
    away = UnavailableError("the bus", "is away", "bring it back")

    @contextlib.asynccontextmanager
    async def lifespan(_app: FastAPI) -> AsyncIterator[None]:
        raise away
        yield

    server = Server(FastAPI(lifespan=lifespan), Settings.load(), lambda: pytest.fail("it answers"))
    with contextlib.closing(listen("127.0.0.1", 0)) as listener, caplog.at_level(logging.INFO):
        asyncio.run(server.serve(sockets=[listener]))
    assert server.failure is away
    assert "Traceback" not in caplog.text


@pytest.mark.parametrize(
    ("url", "option"),
    [
        ("sqlite:///dray.db", ""),
        ("sqlite:////var/lib/dray/my data.db", " --db 'sqlite+aiosqlite:////var/lib/dray/my data.db'"),
        ("postgresql://dray@db/factory", " --db postgresql+asyncpg://dray@db/factory"),
        ("postgresql://dray:secret@db/factory", ""),
    ],
)
def test_whoever_is_greeted_is_told_where_passwords_are_set(url: str, option: str) -> None:
    service = Service(Settings.load(database_url=url), default_plant(), speed=1.0)
    told = greeting_of(service, "http://127.0.0.1:8000", "", {"manager": "once"})
    assert f"dray user password manager{option}, dray user pin NAME{option}.\n" in told
    assert "secret@" not in told
