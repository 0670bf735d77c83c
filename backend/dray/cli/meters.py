"""Metrics of what is beside a gateway: the agents and the simulated network in its process, or the bus.

They count in other threads; reading a number, or copying a small counter, needs no lock.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping

from prometheus_client import Metric
from prometheus_client.core import CounterMetricFamily
from prometheus_client.registry import Collector

from dray.adapters.zenoh_bus import ZenohBus
from dray.worker import Worker
from dray_sim.bridge import BridgedBus
from dray_sim.factory import SimFactory

HANDLED, IGNORED, DROPPED = "handled", "ignored", "dropped"

Counts = Counter[tuple[str, str]]
"""What was counted, and of which kind or for which reason."""


class FactoryMeter(Collector):
    """What a simulated factory and the bridge to it have counted.

    Args:
        factory: built.
        bridge: to it.
    """

    def __init__(self, factory: SimFactory, bridge: BridgedBus) -> None:
        self._factory, self._bridge = factory, bridge
        self._lives: dict[str, tuple[Worker, Counts]] = {}
        """By agent, its last known life, and what that one had counted by then."""
        self._past: Counts = Counter()
        """What earlier lives have counted: the sum of all must never fall."""

    def describe(self) -> Iterable[Metric]:
        """Nothing: names are known when they are collected, and are this module's alone."""
        return ()

    def collect(self) -> Iterator[Metric]:
        """Everything as of now."""
        counts, network = self._counts(), self._factory.bus
        handled = counts[HANDLED, ""]
        yield CounterMetricFamily("dray_agent_events_handled", "Events that agents handled.", value=handled)
        ignored = {reason: count for (what, reason), count in counts.items() if what == IGNORED}
        yield _labelled("agent_messages_ignored", "Messages that changed nothing.", "reason", ignored)
        dropped = {kind: count for (what, kind), count in counts.items() if what == DROPPED}
        yield _labelled("agent_messages_dropped", "Messages that found an inbox full.", "kind", dropped)
        yield CounterMetricFamily(
            "dray_bus_messages_delivered", "Messages that reached an agent.", value=network.delivered
        )
        lost = {**network.lost, "nobody there": network.missed}
        yield _labelled("bus_messages_lost", "Messages that reached nobody.", "reason", lost)
        sides = (self._bridge.inbound, self._bridge.outbound)
        crossing = {
            "heartbeat": sum(side.dropped_heartbeats for side in sides),
            "other": sum(side.dropped_messages for side in sides),
        }
        yield _labelled("bridge_messages_dropped", "Messages between factory and gateway.", "kind", crossing)

    def _counts(self) -> Counts:
        """Over all lives of all agents."""
        for agent, worker in tuple(self._factory.workers.items()):
            known, counted = self._lives.get(agent, (worker, Counter()))
            if known is not worker:
                self._past.update(counted)
            self._lives[agent] = worker, _counted(worker)
        total = Counter(self._past)
        for _, counted in self._lives.values():
            total.update(counted)
        return total


class BusMeter(Collector):
    """What a gateway's place on the bus has counted, by the names that a simulated network's has.

    Args:
        bus: the gateway's.
    """

    def __init__(self, bus: ZenohBus) -> None:
        self._bus = bus

    def describe(self) -> Iterable[Metric]:
        """Nothing: names are known when they are collected, and are this module's alone."""
        return ()

    def collect(self) -> Iterator[Metric]:
        """Everything as of now."""
        bus = self._bus
        yield CounterMetricFamily(
            "dray_bus_messages_delivered", "Messages that reached an agent.", value=bus.delivered
        )
        lost = {
            **dict(bus.refused),
            "on the way": bus.missed,
            "said after leaving": bus.unsaid,
            "an older heartbeat": bus.arrivals.dropped_heartbeats,
            "a full queue": bus.arrivals.dropped_messages,
        }
        yield _labelled("bus_messages_lost", "Messages that reached nobody.", "reason", lost)


def _counted(worker: Worker) -> Counts:
    ignored = {(IGNORED, reason): count for reason, count in dict(worker.ignored).items()}
    return Counter(
        {
            (HANDLED, ""): worker.handled,
            (DROPPED, "heartbeat"): worker.dropped_heartbeats,
            (DROPPED, "other"): worker.dropped_messages,
            **ignored,
        }
    )


def _labelled(name: str, what: str, label: str, values: Mapping[str, int]) -> Metric:
    family = CounterMetricFamily(f"dray_{name}", what, labels=(label,))
    for value, count in values.items():
        family.add_metric((value,), count)
    return family
