"""The stop path, assembled: a thread with its own loop and listener (`dray.gateway.stop`)."""

from __future__ import annotations

import asyncio
import logging
import socket
import sys
import threading
from collections.abc import AsyncIterator, Callable
from concurrent.futures import Future
from contextlib import AbstractContextManager, asynccontextmanager
from dataclasses import dataclass

from dray.adapters.crossing import Crossing
from dray.adapters.security.signing import SigningKey
from dray.adapters.system_clock import SystemClock
from dray.cli.runtime.gateway.guard import Guard
from dray.cli.runtime.gateway.serving import Server, proxies
from dray.cli.runtime.listener import listen
from dray.cli.runtime.telemetry.logs import quieten
from dray.errors import UnavailableError
from dray.gateway.access.access import Access
from dray.gateway.factory.commands import Commands
from dray.gateway.http.hosts import Hosts
from dray.gateway.live.timescale import TimeScale
from dray.gateway.stop.endpoint import StopEndpoint
from dray.gateway.stop.recorder import StopRecorder
from dray.gateway.stop.sender import Stop, StopSender
from dray.messages import CommandAnswered
from dray.messages.speakers import stop_sender_of
from dray.ports import Bus
from dray.settings import Settings

SWITCH_S = 0.001
"""Longest time in which one thread keeps the interpreter from others; 5 ms by default. A stop changes threads some ten times, beside
the gateway and a simulated factory."""

CONNECTIONS, CONNECTIONS_EACH = 160, 64
"""Maximum connections in total, and per address: a tablet keeps one between its requests."""

HEAD_BYTES = 8 * 1024
"""Maximum size of the head of a request for a stop."""

STARTING_S, ENDING_S = 10.0, 5.0
"""Timeouts of the thread's start and end: it has little to do."""

_log = logging.getLogger(__name__)

OpenBus = Callable[[], AbstractContextManager[Bus]]
"""Opens the bus for agents on the running loop."""


@dataclass(frozen=True, slots=True)
class StopPath:
    """The parts of the stop path.

    Attributes:
        listener: its port.
        origin_port: the port of the gateway's own listener.
        settings: the gateway's.
        bus: opened on the thread of stops.
        authority: signs grants.
        time: the two clocks.
        incarnation: of the plant's agents.
        wall_s: the wall clock, callable from any thread; by default the computer's, steered.
    """

    listener: socket.socket
    origin_port: int
    settings: Settings
    bus: OpenBus
    authority: SigningKey
    time: TimeScale
    incarnation: int
    wall_s: Callable[[], float] | None = None

    @asynccontextmanager
    async def beside(self, commands: Commands, access: Access) -> AsyncIterator[None]:
        """Run beside a gateway, as long as the context lasts.

        Args:
            commands: the gateway's, for showing stops.
            access: people and keys, and the audit log.

        Raises:
            UnavailableError: the thread does not start.
            Exception: any that keeps it from starting.
        """
        sys.setswitchinterval(SWITCH_S)
        recorder = StopRecorder(commands, access.audit_log)
        crossing = Crossing(asyncio.get_running_loop())
        thread = _Thread(self, access, commands.ahead_s, recorder, crossing)
        await asyncio.to_thread(thread.start)
        try:
            yield
        finally:
            await asyncio.to_thread(thread.stop)


class _Thread:
    def __init__(
        self,
        way: StopPath,
        access: Access,
        ahead_s: Callable[[str], float],
        recorder: StopRecorder,
        crossing: Crossing,
    ) -> None:
        self._way, self._access, self._recorder, self._crossing = way, access, recorder, crossing
        self._ahead_s = ahead_s
        self._ready: Future[tuple[asyncio.AbstractEventLoop, Server]] = Future()
        self._thread = threading.Thread(target=self._run, name="dray-stop", daemon=True)

    def start(self) -> None:
        self._thread.start()
        try:
            self._ready.result(STARTING_S)
        except TimeoutError:
            raise UnavailableError("the stop path", "does not start", "see the log") from None

    def stop(self) -> None:
        loop, server = self._ready.result()
        loop.call_soon_threadsafe(server.stop)
        self._thread.join(ENDING_S)

    # --- on the thread of stops ------------------------------------------------------------------

    def _run(self) -> None:
        try:
            asyncio.run(self._live())
        except BaseException as error:
            if self._ready.done():
                _log.exception("the stop path has ended")
                raise
            self._ready.set_exception(error)

    async def _live(self) -> None:
        way, settings = self._way, self._way.settings
        # The gateway's own clock belongs to its own thread.
        wall_s = way.wall_s or SystemClock(asyncio.get_running_loop()).now_s
        with way.bus() as bus:
            sender = StopSender(
                bus,
                name=stop_sender_of(settings.gateway_name),
                incarnation=way.incarnation,
                authority=way.authority,
                time=way.time,
                wall_s=wall_s,
                timeout_s=settings.command_timeout_s,
                ahead_s=self._ahead_s,
                sent=self._sent,
                ended=self._ended,
            )
            endpoint = StopEndpoint(
                sender,
                remembered=self._access.remembered,
                hosts=Hosts.of(settings),
                origin_port=way.origin_port,
                public_url=settings.public_url,
                wall_s=wall_s,
            )
            guard = Guard(most=CONNECTIONS, each=CONNECTIONS_EACH, exempt=proxies(settings))
            loop = asyncio.get_running_loop()
            server = Server(
                endpoint,
                settings,
                lambda: self._ready.set_result((loop, server)),
                guard=guard,
                head_bytes=HEAD_BYTES,
                streams=False,
            )
            quieten(settings)
            try:
                await server.serve(sockets=[way.listener])
            finally:
                sender.leave()

    def _sent(self, stop: Stop) -> None:
        self._tell_next(stop, self._recorder.sent, stop)

    def _ended(self, stop: Stop, answer: CommandAnswered | None) -> None:
        self._tell_next(stop, self._recorder.ended, stop, answer)

    def _tell_next(self, stop: Stop, call: Callable[..., None], *args: object) -> None:
        """Record a stop with the next turn of the loop, in the order of these calls.

        Waking the gateway's thread may hand it the interpreter, and under load it takes some time to get that
        back. So the stop leaves first, and so does its answer.
        """
        asyncio.get_running_loop().call_soon(self._tell, stop, call, *args)

    def _tell(self, stop: Stop, call: Callable[..., None], *args: object) -> None:
        """Record a stop that is already sent; a failure to record changes nothing."""
        try:
            self._crossing.order(call, *args)
        except UnavailableError as error:
            _log.error(
                "not in the audit log: stop %s of %s by %s: %s", stop.name, stop.atv, stop.by.id, error
            )


def listen_for_stops(settings: Settings, port: int) -> socket.socket:
    """Take the port for stops.

    Args:
        settings: `host` and `stop_port`.
        port: that of the gateway itself.

    Raises:
        UnavailableError: the port in the settings is unavailable.
    """
    if settings.stop_port is not None:
        return listen(settings.host, settings.stop_port, "DRAY_STOP_PORT")
    if settings.port == 0 or port == 65_535:
        return listen(settings.host, 0, "DRAY_STOP_PORT")
    try:
        return listen(settings.host, port + 1, "DRAY_STOP_PORT")
    except UnavailableError:
        _log.warning("port %d is taken: stops have another one; DRAY_STOP_PORT names one for good", port + 1)
        return listen(settings.host, 0, "DRAY_STOP_PORT")
