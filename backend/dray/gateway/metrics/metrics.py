"""All metrics of one gateway, in a registry of its own."""

from __future__ import annotations

from collections.abc import Iterable

from prometheus_client import Histogram, generate_latest
from prometheus_client.registry import Collector

from dray.adapters.telemetry.metrics_port import new_registry
from dray.gateway.metrics.meter import Meter

REQUEST_BUCKETS_S = (0.001, 0.0025, 0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1.0, 2.5, 5.0)
"""From an answer out of memory to one that waits for a vehicle."""


class Metrics:
    """The metrics.

    Args:
        collectors: metrics of other parts of this process.

    Attributes:
        registry: registry of all metrics.
        meter: counts messages on the bus.
        requests: durations of requests.
    """

    def __init__(self, collectors: Iterable[Collector] = ()) -> None:
        self.registry = new_registry()
        self.meter = Meter(self.registry)
        self.requests = Histogram(
            "dray_http_request_duration_seconds",
            "Time from a request to the end of its answer.",
            ("method", "route", "status"),
            buckets=REQUEST_BUCKETS_S,
            registry=self.registry,
        )
        for collector in collectors:
            self.add(collector)

    def add(self, collector: Collector) -> None:
        """Add a collector."""
        self.registry.register(collector)

    def text(self) -> bytes:
        """All present values in Prometheus' text format."""
        return generate_latest(self.registry)
