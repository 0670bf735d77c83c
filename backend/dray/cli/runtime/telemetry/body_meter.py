"""The metric of failures in handling a body's messages."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence

from prometheus_client import Metric
from prometheus_client.registry import Collector

from dray.adapters.telemetry.metric_families import counters
from dray.supervision import Failures


class BodyMeter(Collector):
    """Our own faults with the messages of one body.

    Args:
        failures: the counted failures.
    """

    def __init__(self, failures: Sequence[Failures]) -> None:
        self._failures = failures

    def collect(self) -> Iterator[Metric]:
        """All present metrics."""
        counts = sum((each.counts for each in self._failures), Counter[str]())
        what = "Messages of a body that could not be dealt with, by our own fault."
        yield counters("body_messages_failed", what, "kind", counts)
