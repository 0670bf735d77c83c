"""Traces and the log of facts, for the agents of a process: only what the settings ask for is active."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from dray.adapters.telemetry.fact_log import LoggedBus
from dray.adapters.telemetry.traffic_log import TrafficLoggedBus
from dray.ports import Bus
from dray.settings import Settings

if TYPE_CHECKING:
    from opentelemetry.sdk.trace import TracerProvider


@contextmanager
def traced(settings: Settings) -> Iterator[TracerProvider | None]:
    """The receiver of spans while the process runs; None without tracing. Sends the rest at the end."""
    if not settings.trace_url:
        yield None
        return
    from dray.adapters.telemetry.tracing import open_provider, otlp

    provider = open_provider(settings.trace_share_frac, otlp(settings.trace_url))
    try:
        yield provider
    finally:
        provider.shutdown()


def watched(
    settings: Settings, provider: TracerProvider | None, to_wall_s: Callable[[float], float]
) -> Callable[[Bus], Bus]:
    """A function that wraps a bus with logs and traces.

    Args:
        settings: the log format and the traffic log.
        provider: the receiver of spans, if any.
        to_wall_s: plant clock to wall clock.
    """

    def meet(bus: Bus) -> Bus:
        if settings.log_format == "json":
            bus = LoggedBus(bus)
        if settings.traffic_log is not None:
            bus = TrafficLoggedBus(bus, settings.traffic_log)
        if provider is not None:
            from dray.adapters.telemetry.tracing import TracedBus

            bus = TracedBus(bus, provider, to_wall_s)
        return bus

    return meet
