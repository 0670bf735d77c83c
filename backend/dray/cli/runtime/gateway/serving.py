"""The server of a command: it reports when it serves, leaves signals to others, and explains a failed start."""

from __future__ import annotations

import contextlib
import socket
from collections.abc import Callable, Generator
from typing import Any

import uvicorn

from dray.cli.runtime.gateway.guard import Guard, guarded, room_for
from dray.cli.runtime.listener import BACKLOG
from dray.settings import Settings

ACCEPTED_AT_ONCE = 8
"""Waiting connections (`BACKLOG`) accepted per turn of the loop: few against the limit per address (`Guard`). So no connection is
ended for later ones before anything was read from it."""

INCOMING_BYTES = 4096
"""Maximum size of a panel's message on the stream: it has little to send."""

HEAD_BYTES = 32 * 1024
"""Maximum size of a request's head: an address with a filter, and the cookies of a host with other servers."""

GOODBYE_S = 3
"""Wall seconds for open requests at the server's end: only commands may take longer."""


class _Candid:
    """An ASGI application whose failed start is stored instead of logged.

    Args:
        app: the application.

    Attributes:
        failure: the exception that has ended its lifespan.
    """

    def __init__(self, app: Any) -> None:
        self._app = app
        self.failure: BaseException | None = None

    async def __call__(self, scope: Any, receive: Any, send: Any) -> None:
        """See the ASGI specification."""
        if scope["type"] != "lifespan":
            await self._app(scope, receive, send)
            return

        async def send_without_traceback(message: dict[str, Any]) -> None:
            await send({name: value for name, value in message.items() if name != "message"})

        try:
            await self._app(scope, receive, send_without_traceback)
        except BaseException as failure:
            self.failure = failure
            raise


class Server(uvicorn.Server):
    """uvicorn with a callback when it serves, without signal handling, and with the reason of a failed start.

    Args:
        app: an ASGI application.
        settings: the log level, and the trusted proxies.
        on_ready: called once, when requests are served.
        guard: limits its connections; by default from the settings.
        head_bytes: maximum size of a request's head.
        streams: whether there are any streams.
    """

    def __init__(
        self,
        app: Any,
        settings: Settings,
        on_ready: Callable[[], None],
        *,
        guard: Guard | None = None,
        head_bytes: int = HEAD_BYTES,
        streams: bool = True,
    ) -> None:
        self._candid = _Candid(app)
        self.guard = guard or Guard(
            most=room_for(settings.connections),
            each=settings.connections_each,
            exempt=proxies(settings),
        )
        http, socket = guarded(self.guard)
        config = uvicorn.Config(
            self._candid,
            http=http,
            ws=socket if streams else "none",
            h11_max_incomplete_event_size=head_bytes,
            # For asyncio: the number accepted at once, before the guard sees any of them.
            backlog=ACCEPTED_AT_ONCE,
            log_level=settings.log_level,
            # Ours: see `dray.cli.runtime.gateway.service`.
            log_config=None,
            access_log=settings.log_level == "debug",
            # Otherwise uvicorn would believe any program on this machine about its client's address.
            proxy_headers=bool(settings.trusted_proxies),
            forwarded_allow_ips=[str(network) for network in settings.trusted_proxies],
            server_header=False,
            ws_max_size=INCOMING_BYTES,
            # Each client's frames are compressed with the earlier ones as context: a fifth of the bytes, for some 20 us a frame.
            ws_per_message_deflate=True,
            timeout_graceful_shutdown=GOODBYE_S,
        )
        super().__init__(config)
        self._on_ready = on_ready

    async def on_tick(self, counter: int) -> bool:
        """Called ten times a second; sweeps overdue connections once a second."""
        if counter % 10 == 0:
            self.guard.sweep()
        return await super().on_tick(counter)

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        """Start to serve."""
        try:
            await super().startup(sockets)
            for each in sockets or ():
                each.listen(BACKLOG)  # asyncio has also used the number above as the length of the queue.
        except SystemExit:
            # uvicorn would exit with a code of its own.
            if self.failure is None:
                raise
            self.should_exit = True
        if self.started:
            self._on_ready()

    @property
    def failure(self) -> BaseException | None:
        """Why the application could not start, or has ended; None without a failure."""
        return self._candid.failure

    def stop(self) -> None:
        """Serve the open requests, and end."""
        self.should_exit = True

    @contextlib.contextmanager
    def capture_signals(self) -> Generator[None]:
        """Leave signals to `stopped_by_signals`: uvicorn would end the process with the signal."""
        yield


def proxies(settings: Settings) -> list[str]:
    """The networks of trusted proxies: each address speaks for many."""
    return [str(network) for network in settings.trusted_proxies]
