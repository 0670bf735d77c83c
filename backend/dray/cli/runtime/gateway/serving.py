"""The server of a command: it says when it answers, leaves signals to others, and tells why it cannot start."""

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
"""Of the connections that wait (`BACKLOG`), in one turn of the loop: few against what an address may have (`Guard`), so that nobody is sent away to
make room for those behind before anything was read of it."""

INCOMING_BYTES = 4096
"""Longest message that a panel may send on the stream: it has nothing to say."""

HEAD_BYTES = 32 * 1024
"""Longest head of a request: an address with a filter, and the cookies of a host with other servers."""

GOODBYE_S = 3
"""Wall seconds that open requests get when the server ends: no answer takes longer, but a command."""


class _Candid:
    """An ASGI application whose failure to start is kept, and not written to the log.

    Args:
        app: the application.

    Attributes:
        failure: what has ended its lifespan.
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
    """uvicorn with a word when it answers, with signals left to us, and with the reason when it cannot start.

    Args:
        app: an ASGI application.
        settings: how much is logged, and which proxies are trusted.
        on_ready: called once, when requests are answered.
        guard: of its connections; that of the settings, when absent.
        head_bytes: longest head of a request.
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
            # To asyncio: how many are accepted in one go, before the guard sees any of them.
            backlog=ACCEPTED_AT_ONCE,
            log_level=settings.log_level,
            # Ours: see `dray.cli.runtime.gateway.service`.
            log_config=None,
            access_log=settings.log_level == "debug",
            # Else uvicorn would believe every program on this machine what address it speaks for.
            proxy_headers=bool(settings.trusted_proxies),
            forwarded_allow_ips=settings.trusted_proxies,
            server_header=False,
            ws_max_size=INCOMING_BYTES,
            # Each client's frames are compressed on what it was sent before: a fifth of the bytes, for some 20 us a frame.
            ws_per_message_deflate=True,
            timeout_graceful_shutdown=GOODBYE_S,
        )
        super().__init__(config)
        self._on_ready = on_ready

    async def on_tick(self, counter: int) -> bool:
        """Ten times a second; see that nobody keeps us waiting once in each."""
        if counter % 10 == 0:
            self.guard.sweep()
        return await super().on_tick(counter)

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        """Start to answer."""
        try:
            await super().startup(sockets)
            for each in sockets or ():
                each.listen(BACKLOG)  # It took the number above for the length of the queue as well.
        except SystemExit:
            # uvicorn would end the process with a code of its own.
            if self.failure is None:
                raise
            self.should_exit = True
        if self.started:
            self._on_ready()

    @property
    def failure(self) -> BaseException | None:
        """Why the application could not start, or was ended; None while all is well."""
        return self._candid.failure

    def stop(self) -> None:
        """Answer what has been asked, and end."""
        self.should_exit = True

    @contextlib.contextmanager
    def capture_signals(self) -> Generator[None]:
        """Leave signals to `stopped_by_signals`: uvicorn would end the process by the signal."""
        yield


def proxies(settings: Settings) -> list[str]:
    """The addresses of trusted proxies: each speaks for many."""
    return [each.strip() for each in settings.trusted_proxies.split(",") if each.strip()]
