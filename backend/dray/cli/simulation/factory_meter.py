"""Metrics of a whole simulated factory.

The factory counts in another thread; reading a number, or copying a small counter, needs no lock.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

from prometheus_client import Metric
from prometheus_client.registry import Collector

from dray.adapters.telemetry.metric_families import counter, counters
from dray.cli.runtime.telemetry.agent_meter import Counts, counted, families_of
from dray.worker.worker import Worker
from dray_sim.factory.sim_factory import SimFactory
from dray_sim.network.bridge import BridgedBus


class FactoryMeter(Collector):
    """The counts of a simulated factory and of the bridge to it.

    Args:
        factory: a built factory.
        bridge: the bridge to it.
    """

    def __init__(self, factory: SimFactory, bridge: BridgedBus) -> None:
        self._factory, self._bridge = factory, bridge
        self._lives: dict[str, tuple[Worker, Counts]] = {}
        """By agent, its last known life, and that life's counts so far."""
        self._past: Counts = Counter()
        """The counts of earlier lives: the sum over lives must never fall."""

    def collect(self) -> Iterator[Metric]:
        """All present metrics."""
        network = self._factory.bus
        yield from families_of(self._counts())
        yield counter("bus_messages_delivered", "Messages that reached an agent.", network.delivered)
        lost = {**network.lost, "nobody there": network.missed}
        yield counters("bus_messages_lost", "Messages that reached nobody.", "reason", lost)
        sides = (self._bridge.inbound, self._bridge.outbound)
        crossing = {
            "heartbeat": sum(side.dropped_heartbeats for side in sides),
            "other": sum(side.dropped_messages for side in sides),
        }
        yield counters("bridge_messages_dropped", "Messages between factory and gateway.", "kind", crossing)

    def _counts(self) -> Counts:
        """The counts over all lives of all agents."""
        for agent, worker in tuple(self._factory.workers.items()):
            known, before = self._lives.get(agent, (worker, Counter()))
            if known is not worker:
                self._past.update(before)
            self._lives[agent] = worker, counted(worker)
        total = Counter(self._past)
        for _, now in self._lives.values():
            total.update(now)
        return total
