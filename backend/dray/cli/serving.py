"""Serving HTTP: a port that is ours before anything starts, and a server that stops cleanly."""

from __future__ import annotations

import asyncio
import contextlib
import os
import signal
import socket
from collections.abc import Callable, Generator
from typing import Any

import uvicorn

from dray.errors import UnavailableError

STOP_S = 3
"""How long open connections may take to end; a browser's websocket ends at once."""

BACKLOG = 128
"""Connections that wait to be accepted: more than a plant has browsers."""


def open_port(host: str, port: int) -> socket.socket:
    """Listen.

    Args:
        host: a name or address of this machine.
        port: 0 lets the system choose one.

    Raises:
        UnavailableError: the port is in use, not allowed, or the host is no address of this machine.
    """
    what = f"port {port} on {host}"
    try:
        family, _, _, _, address = socket.getaddrinfo(
            host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE
        )[0]
    except (OSError, UnicodeError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise UnavailableError(f"host {host}", reason, "choose another one with --host") from None
    listener = socket.socket(family, socket.SOCK_STREAM)
    try:
        if os.name == "posix":
            # A port whose last connections are fading may be used at once; one that is in use may not.
            listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listener.bind(address)
        listener.listen(BACKLOG)
    except OSError as error:
        listener.close()
        reason = error.strerror or str(error)
        remedy = "end the program that uses it, or choose another one with --port (0: any free one)"
        raise UnavailableError(what, reason[:1].lower() + reason[1:], remedy) from None
    listener.setblocking(False)
    return listener


def address_of(listener: socket.socket, host: str) -> str:
    """What to type into a browser on this machine."""
    port = listener.getsockname()[1]
    if host in {"0.0.0.0", "::", ""}:  # noqa: S104 (compared with, not bound to)
        host = "127.0.0.1"
    return f"http://[{host}]:{port}" if ":" in host else f"http://{host}:{port}"


class Server(uvicorn.Server):
    """uvicorn, with signals left to us and a word when it answers.

    Args:
        app: an ASGI application.
        log_level: as in `Settings`.
        on_ready: called once, when requests are answered.
    """

    def __init__(self, app: Any, log_level: str, on_ready: Callable[[], None]) -> None:
        super().__init__(
            uvicorn.Config(
                app,
                log_level="warning" if log_level == "info" else log_level,
                access_log=log_level == "debug",
                timeout_graceful_shutdown=STOP_S,
                server_header=False,
            )
        )
        self._on_ready = on_ready

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        """Start to answer."""
        await super().startup(sockets)
        if self.started:
            self._on_ready()

    @contextlib.contextmanager
    def capture_signals(self) -> Generator[None]:
        """Leave them to `until_signal`: uvicorn's own way ends the process by the signal."""
        yield


@contextlib.contextmanager
def on_signal(stop: Callable[[], None]) -> Generator[None]:
    """Call `stop` on Ctrl-C or SIGTERM, on the running loop; a second Ctrl-C interrupts at once."""
    loop = asyncio.get_running_loop()

    def stopping() -> None:
        for each in signals:
            loop.remove_signal_handler(each)
        stop()

    signals = (signal.SIGINT, signal.SIGTERM)
    for each in signals:
        loop.add_signal_handler(each, stopping)
    try:
        yield
    finally:
        for each in signals:
            loop.remove_signal_handler(each)
