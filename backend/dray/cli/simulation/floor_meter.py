"""Metrics of a simulated floor for agents elsewhere."""

from __future__ import annotations

from collections.abc import Iterator

from prometheus_client import Metric
from prometheus_client.registry import Collector

from dray.adapters.telemetry.metric_families import counter, counters, gauge, gauges
from dray_sim.remote import FloorMonitor, FloorServer


class FloorMeter(Collector):
    """The messages between a floor's bodies and their agents.

    Args:
        server: the floor's server.
        monitor: detects two vehicles in one place, if there is one.
    """

    def __init__(self, server: FloorServer, monitor: FloorMonitor | None = None) -> None:
        self._server, self._monitor = server, monitor

    def collect(self) -> Iterator[Metric]:
        """All present metrics."""
        traffic = self._server.traffic
        yield gauges(
            "floor_bodies", "Simulated bodies, by whether an agent has them.", "state", traffic.bodies
        )
        yield counter("floor_reports", "What bodies have reported to their agents.", traffic.reports)
        yield counter("floor_reports_repeated", "Reports that were told once more.", traffic.again)
        yield gauge("floor_reports_waiting", "Reports that are not heard yet.", traffic.waiting)
        yield counter("floor_instructions", "What agents have instructed their bodies.", traffic.instructions)
        yield counters(
            "floor_letters_refused", "Agents' letters that nobody obeyed.", "reason", traffic.refused
        )
        if self._monitor is not None:
            yield counter(
                "floor_overlaps", "How often two vehicles came into one spot.", self._monitor.overlaps
            )
