"""One server of the benchmark.

python -m dray_sim.bench.orders bare|ours URL PORT
"""

from __future__ import annotations

import asyncio
import sys
import time
from collections.abc import Callable
from typing import Any

import uvicorn

from dray.adapters.security.signing import SigningKey
from dray.gateway.app import create_app
from dray.gateway.live.timescale import TimeScale
from dray.messages import Message, OrderReleased, OrderTaken
from dray.plant import default_plant
from dray.ports import Receive
from dray.settings import Settings
from dray.store import open_store
from dray_sim.bench.orders.bare import create_bare_app


class _Strategists:
    """A bus on which a strategist takes every order as soon as it hears of it."""

    context = ""

    def __init__(self) -> None:
        self._receive: Callable[[str, Message], None] | None = None

    def join(self, agent: str, receive: Receive, life: int = 1) -> _Strategists:
        self._receive = receive
        return self

    def send(self, to: str, message: Message) -> None:
        if isinstance(message, OrderReleased) and self._receive is not None:
            taken = OrderTaken(order=message.order, release=message.release)
            asyncio.get_running_loop().call_soon(self._receive, "strategist", taken)

    def publish(self, key: str, message: Message) -> None:
        """Nobody listens."""

    def subscribe(self, key: str) -> None:
        """Nobody else speaks."""

    def unsubscribe(self, key: str) -> None:
        """Nobody else speaks."""

    def leave(self) -> None:
        """Nobody notices."""


UNLIMITED = 10_000
"""Requests a second that a key may make, and at once: customers wait for nothing but their answers."""


async def _serve(kind: str, url: str, port: int) -> None:
    if kind == "bare":
        await _answer(create_bare_app(url), port)
        return
    store = await open_store(url)
    try:
        settings = Settings.load(database_url=url, key_rate_hz=UNLIMITED, key_burst=UNLIMITED)
        app = create_app(
            settings=settings,
            plant=default_plant().file,
            bus=_Strategists(),
            store=store,
            time=TimeScale(0.0, time.time(), 1.0),
            authority=SigningKey(SigningKey.generate()),
        )
        await _answer(app, port)
    finally:
        await store.close()


async def _answer(app: Any, port: int) -> None:
    config = uvicorn.Config(app, host="127.0.0.1", port=port, log_level="error", access_log=False)
    await uvicorn.Server(config).serve()


if __name__ == "__main__":
    asyncio.run(_serve(sys.argv[1], sys.argv[2], int(sys.argv[3])))
