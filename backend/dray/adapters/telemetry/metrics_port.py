"""A port at which Prometheus reads one process's metrics.

Prometheus' own little server answers on its own threads, but reads the values on the process's loop. So no value is read during
a change, and a process whose loop hangs gives no answer, as it should.

There is no login: listen only where Prometheus alone can connect.
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
"""Longest wait for the loop: half of Prometheus' default timeout."""


Read = Callable[[], Awaitable[Iterable[Metric]]]
"""Reads the present metrics."""


_log = logging.getLogger(__name__)


def new_registry() -> CollectorRegistry:
    """Metrics of all processes: the software version, and the use of the computer's resources."""
    registry = CollectorRegistry()
    Info("dray_build", "This software.", registry=registry).info({"version": __version__})
    ProcessCollector(registry=registry)
    GCCollector(registry=registry)
    return registry


@asynccontextmanager
async def metrics_port(address: str, read: Read) -> AsyncIterator[int]:
    """Serve metrics until the context ends; gives the port.

    Args:
        address: HOST:PORT; 0 lets the system choose a port.
        read: reads all present values; called on the running loop.

    Raises:
        UnavailableError: listening on the address failed.
    """
    told = CollectorRegistry()
    told.register(_OnLoop(asyncio.get_running_loop(), read))
    host, port = host_and_port(address)
    try:
        # Resolving the host name may take a while.
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
    """Reads on the loop for a request on another thread."""

    def __init__(self, loop: asyncio.AbstractEventLoop, read: Read) -> None:
        self._loop, self._read = loop, read

    def collect(self) -> Iterable[Metric]:
        """All present metrics."""
        return asyncio.run_coroutine_threadsafe(self._all(), self._loop).result(ANSWER_S)

    async def _all(self) -> list[Metric]:
        return list(await self._read())
