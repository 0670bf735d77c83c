"""Metrics of agents: of one with its own process, or of all lives of many together."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

from prometheus_client import Metric
from prometheus_client.core import SummaryMetricFamily
from prometheus_client.registry import Collector

from dray.adapters.journal.sqlite_journal import SqliteJournal
from dray.adapters.telemetry.metric_families import counter, counters, gauge
from dray.worker.worker import Worker

HANDLED, IGNORED, DROPPED = "handled", "ignored", "dropped"

Counts = Counter[tuple[str, str]]
"""Counts by name, and by kind or reason."""


class AgentMeter(Collector):
    """The counts of one agent and its journal in this life.

    Args:
        worker: the agent's worker.
        journal: the agent's.
    """

    def __init__(self, worker: Worker, journal: SqliteJournal) -> None:
        self._worker, self._journal = worker, journal

    def collect(self) -> Iterator[Metric]:
        """All present metrics."""
        yield from families_of(counted(self._worker))
        yield gauge("agent_events_waiting", "Events in an agent's inbox.", len(self._worker.inbox.waiting))
        yield SummaryMetricFamily(
            "dray_journal_write_seconds",
            "Time until what an agent is bound by is on its disk.",
            count_value=self._journal.writes,
            sum_value=self._journal.writing_s,
        )


def counted(worker: Worker) -> Counts:
    """An agent's counts in this life."""
    ignored = {(IGNORED, reason): count for reason, count in dict(worker.ignored).items()}
    return Counter(
        {
            (HANDLED, ""): worker.handled,
            (DROPPED, "heartbeat"): worker.inbox.dropped_heartbeats,
            (DROPPED, "other"): worker.inbox.dropped_messages,
            **ignored,
        }
    )


def families_of(counts: Counts) -> Iterator[Metric]:
    """Agents' counts as Prometheus metrics."""
    yield counter("agent_events_handled", "Events that agents handled.", counts[HANDLED, ""])
    ignored = {reason: count for (what, reason), count in counts.items() if what == IGNORED}
    yield counters("agent_messages_ignored", "Messages that changed nothing.", "reason", ignored)
    dropped = {kind: count for (what, kind), count in counts.items() if what == DROPPED}
    yield counters("agent_messages_dropped", "Messages that found an inbox full.", "kind", dropped)
