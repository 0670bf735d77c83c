"""History: the historian's progress."""

from __future__ import annotations

from collections.abc import Iterator

from prometheus_client import Metric
from prometheus_client.registry import Collector

from dray.adapters.telemetry.metric_families import counter, counters, gauge
from dray.store import Historian


class History(Collector):
    """Reads a historian's figures.

    Args:
        historian: the historian in this process.
    """

    def __init__(self, historian: Historian) -> None:
        self._historian = historian

    def collect(self) -> Iterator[Metric]:
        """The present values."""
        historian = self._historian
        yield gauge("historian_up", "Whether the historian can write.", not historian.failing)
        yield counters(
            "historian_task_restarts",
            "Failures of tasks of the historian, each of which was started again; the log has the reason.",
            "task",
            historian.supervisor.restarts,
        )
        yield gauge("historian_waiting_events", "Events heard and not written yet.", historian.waiting)
        yield gauge("historian_behind_seconds", "How long the oldest of them has waited.", historian.behind_s)
        yield counter("historian_events_kept", "Events written.", historian.kept)
        yield counter(
            "historian_events_lost",
            "Events that found the queue full, or were refused by the database.",
            historian.lost,
        )
        yield gauge(
            "historian_numbers_missing", "Events that are known to lack and are asked for.", historian.missing
        )
        yield counter("historian_numbers_gone", "Events that nobody has any more.", historian.gone)
        yield counter(
            "historian_events_forgotten_early",
            "Events that were forgotten before their time, because there were too many.",
            0 if historian.retention is None else historian.retention.too_many,
        )
