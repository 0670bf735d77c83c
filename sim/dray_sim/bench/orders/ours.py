"""Our gateway as benchmarks serve it, with a strategist that takes every order at once."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable
from typing import Any

import uvicorn
from fastapi import FastAPI

from dray.adapters.security.signing import SigningKey
from dray.gateway.app import create_app
from dray.gateway.live.timescale import TimeScale
from dray.messages import Message, OrderReleased, OrderTaken
from dray.plant import default_plant
from dray.ports import Receive
from dray.settings import Settings
from dray.store import Store

UNLIMITED = 10_000
"""Requests a second that a key may make, and at once: customers wait for nothing but their answers."""


class Strategists:
    """A bus on which a strategist takes every order as soon as it hears of it."""

    context = ""

    def __init__(self) -> None:
        self._receive: Callable[[str, Message], None] | None = None

    def join(self, agent: str, receive: Receive, life: int = 1) -> Strategists:
        self._receive = receive
        return self

    def send(self, to: str, message: Message) -> None:
        if isinstance(message, OrderReleased) and self._receive is not None:
            taken = OrderTaken(order=message.order, release=message.release)
            asyncio.get_running_loop().call_soon(self._receive, "strategist", taken)

    def publish(self, key: str, message: Message) -> None:
        """Do nothing: nobody listens."""

    def subscribe(self, key: str) -> None:
        """Do nothing: nobody else publishes."""

    def unsubscribe(self, key: str) -> None:
        """Do nothing: nobody else publishes."""

    def leave(self) -> None:
        """Do nothing: nobody listens."""


def our_app(url: str, store: Store, wall_s: Callable[[], float] = time.time) -> FastAPI:
    """The gateway of the default plant.

    Args:
        url: of the database.
        store: open on it.
        wall_s: the wall clock.
    """
    return create_app(
        settings=Settings.load(database_url=url, key_rate_hz=UNLIMITED, key_burst=UNLIMITED),
        plant=default_plant().file,
        bus=Strategists(),
        store=store,
        time=TimeScale(0.0, wall_s(), 1.0),
        authority=SigningKey(SigningKey.generate()),
        wall_s=wall_s,
    )


async def answer(app: Any, port: int) -> None:
    """Serve an application on 127.0.0.1, until a signal."""
    config = uvicorn.Config(app, host="127.0.0.1", port=port, log_level="error", access_log=False)
    await uvicorn.Server(config).serve()
