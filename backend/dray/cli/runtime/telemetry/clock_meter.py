"""Metrics of the plant's clock in this process, against the computer's."""

from __future__ import annotations

from collections.abc import Iterator

from prometheus_client import Metric
from prometheus_client.registry import Collector

from dray.adapters.system_clock import SystemClock
from dray.adapters.telemetry.metric_families import counter, gauge


class ClockMeter(Collector):
    """The measurements of one clock.

    Args:
        clock: the process's clock.
    """

    def __init__(self, clock: SystemClock) -> None:
        self._clock = clock

    def collect(self) -> Iterator[Metric]:
        """All present metrics."""
        self._clock.now_s()
        yield counter("clock_steps", "How often the computer's clock was set.", self._clock.steps)
        yield gauge(
            "clock_behind_seconds",
            "What the process's clock still has to make up for; below 0 when it is ahead.",
            self._clock.behind_s,
        )
