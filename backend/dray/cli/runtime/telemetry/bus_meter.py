"""Metrics of a process's connection to the bus, with the names of a simulated network's metrics."""

from __future__ import annotations

from collections.abc import Iterator

from prometheus_client import Metric
from prometheus_client.registry import Collector

from dray.adapters.telemetry.metric_families import counter, counters, gauge
from dray.adapters.zenoh.bus import FAILED, ZenohBus


class BusMeter(Collector):
    """The counts of one connection to the bus.

    Args:
        bus: the process's bus.
    """

    def __init__(self, bus: ZenohBus) -> None:
        self._bus = bus

    def collect(self) -> Iterator[Metric]:
        """All present metrics."""
        bus = self._bus
        yield counter("bus_messages_delivered", "Messages that reached an agent.", bus.delivered)
        lost = {
            **dict(bus.refused),
            "on the way": bus.missed,
            "said after leaving": bus.unsaid,
            "nobody there to read it": bus.unaddressed,
            "an older heartbeat": bus.arrivals.dropped_heartbeats,
            "a full queue": bus.arrivals.dropped_messages,
            FAILED: bus.failures.total + bus.arrivals.failures.total,
        }
        yield counters("bus_messages_lost", "Messages that reached nobody.", "reason", lost)
        if bus.seals is not None:
            yield gauge(
                "certificate_expiry_timestamp_seconds",
                "Until when the process's certificate is valid, as unix time.",
                bus.seals.until_s,
            )
