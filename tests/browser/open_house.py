"""The gateway of the gateway's tests, served to a browser: every agent is the test's, and so is the clock.

It lives on a thread with an event loop of its own, since Playwright's pages and an event loop do not
share one thread.
"""

from __future__ import annotations

import asyncio
import socket
import sys
import threading
from collections.abc import Callable, Coroutine, Iterator
from concurrent.futures import Future
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeVar

import uvicorn

sys.path.insert(0, str(Path(__file__).parents[1] / "gateway/kits"))

from gateway_kit import House, gateway

T = TypeVar("T")

PATIENCE_S = 90.0
"""Longest wait for the house to open or close, and for one call: thirty times what a slow machine takes."""


class OpenHouse:
    """A gateway that browsers can reach, and that a test can speak to between two looks at a page.

    Args:
        url: where its pages are, without a slash at the end.
        house: the gateway, which only its own loop may touch.
        loop: that loop.
    """

    def __init__(self, url: str, house: House, loop: asyncio.AbstractEventLoop) -> None:
        self.url, self._house, self._loop = url, house, loop

    def do(self, work: Callable[[House], Coroutine[Any, Any, T]]) -> T:
        """Run this on the gateway's loop, and wait for it."""
        return asyncio.run_coroutine_threadsafe(work(self._house), self._loop).result(PATIENCE_S)

    def until(self, probe: Callable[[House], T]) -> T:
        """Let the gateway go on until this gives something, and return that: an answer to a page may be ahead of the bus."""

        async def look(house: House) -> T:
            while not (found := probe(house)):  # noqa: ASYNC110 (what is probed has no event of its own)
                await asyncio.sleep(0)
            return found

        return self.do(look)


@contextmanager
def open_house(url: str, **options: Any) -> Iterator[OpenHouse]:
    """Serve a gateway on a free port, with its database at `url`; for options see `gateway`."""
    opened: Future[tuple[OpenHouse, uvicorn.Server]] = Future()

    def run() -> None:
        try:
            asyncio.run(_live(url, opened, options))
        except BaseException as error:
            if opened.done():
                raise
            opened.set_exception(error)

    thread = threading.Thread(target=run)
    thread.start()
    house, server = opened.result(PATIENCE_S)
    try:
        yield house
    finally:
        server.should_exit = True
        thread.join(PATIENCE_S)
        assert not thread.is_alive()


async def _live(url: str, opened: Future[tuple[OpenHouse, uvicorn.Server]], options: dict[str, Any]) -> None:
    with socket.create_server(("127.0.0.1", 0)) as listener:
        async with gateway(url, **options) as house:
            # `gateway` has started the application already.
            server = uvicorn.Server(uvicorn.Config(house.app, lifespan="off", log_level="error"))
            home = f"http://127.0.0.1:{listener.getsockname()[1]}"
            opened.set_result((OpenHouse(home, house, asyncio.get_running_loop()), server))
            await server.serve(sockets=[listener])
