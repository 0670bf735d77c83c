"""A port at which Prometheus asks one process for its metrics.

Prometheus' own little server answers on threads of its own; what it tells is read on the process's loop, as
everything is that the process does. So nothing is read that is being changed, and a process whose loop hangs
gives no answer, as it should.

Nobody has to log in: listen where only Prometheus reaches.
"""

from __future__ import annotations

import asyncio
import logging
from collections.abc import AsyncIterator, Awaitable, Callable, Iterable
from contextlib import asynccontextmanager

from prometheus_client import (
    CollectorRegistry,
    GCCollector,
    Info,
    Metric,
    ProcessCollector,
    start_http_server,
)
from prometheus_client.registry import Collector

from dray import __version__
from dray.errors import UnavailableError
from dray.settings import host_and_port

ANSWER_S = 5.0
"""Longest wait for the loop: half of the time that Prometheus itself waits, unless told otherwise."""


Read = Callable[[], Awaitable[Iterable[Metric]]]
"""Tells metrics as of now."""


_log = logging.getLogger(__name__)


def new_registry() -> CollectorRegistry:
    """What every process tells: which software it is, and what it takes of the computer."""
    registry = CollectorRegistry()
    Info("dray_build", "This software.", registry=registry).info({"version": __version__})
    ProcessCollector(registry=registry)
    GCCollector(registry=registry)
    return registry


@asynccontextmanager
async def metrics_port(address: str, read: Read) -> AsyncIterator[int]:
    """Answer as long as the context lasts; gives the port.

    Args:
        address: HOST:PORT; 0 lets the system choose a port.
        read: tells everything as of now; called on the running loop.

    Raises:
        UnavailableError: the address cannot be listened on.
    """
    told = CollectorRegistry()
    told.register(_OnLoop(asyncio.get_running_loop(), read))
    host, port = host_and_port(address)
    try:
        # The name of the host is looked up, which may take a while.
        server, thread = await asyncio.to_thread(start_http_server, port, host, told)
    except (OSError, UnicodeError) as error:
        remedy = "name a free port of this computer in DRAY_METRICS_LISTEN, or leave it empty"
        reason = getattr(error, "strerror", None) or str(error)
        raise UnavailableError(f"metrics at {address}", reason, remedy) from error
    _log.info("metrics on port %d of %s", server.server_port, host)
    try:
        yield server.server_port
    finally:
        await asyncio.to_thread(server.shutdown)
        server.server_close()
        thread.join()


class _OnLoop(Collector):
    """Reads on the loop what is asked for on another thread."""

    def __init__(self, loop: asyncio.AbstractEventLoop, read: Read) -> None:
        self._loop, self._read = loop, read

    def collect(self) -> Iterable[Metric]:
        """Everything as of now."""
        return asyncio.run_coroutine_threadsafe(self._all(), self._loop).result(ANSWER_S)

    async def _all(self) -> list[Metric]:
        return list(await self._read())
