"""State: what the parts of a gateway know anyway, read when Prometheus asks."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from prometheus_client import Metric
from prometheus_client.core import CounterMetricFamily, GaugeMetricFamily
from prometheus_client.registry import Collector

from dray.gateway.health import Health
from dray.gateway.parts import Parts
from dray.messages import AtvStatus, MachineStatus
from dray.store import Historian
from dray.store.progress import OPEN, OrderStatus


class State(Collector):
    """Reads the parts.

    Args:
        parts: of a running gateway.
    """

    def __init__(self, parts: Parts) -> None:
        self._parts = parts

    def describe(self) -> Iterable[Metric]:
        """Nothing: names are known when they are collected, and are this module's alone."""
        return ()

    def collect(self) -> Iterator[Metric]:
        """Everything as of now."""
        yield from self._factory()
        yield from self._gateway()
        yield from self._database(self._parts.health)
        if self._parts.historian is not None:
            yield from _history(self._parts.historian)

    def _factory(self) -> Iterator[Metric]:
        projection = self._parts.projection
        open_orders = projection.orders.by_status
        yield _split(
            "orders_open",
            "Orders that have not ended.",
            {s: open_orders[s] for s in (OrderStatus.STORED, *OPEN)},
        )
        yield _gauge("orders_delivered", "Orders that were ever delivered.", projection.orders.delivered)
        yield _gauge("orders_delivered_on_time", "Of these, by their due time.", projection.orders.on_time)
        atvs, machines = projection.atvs.by_status, projection.machines.by_status
        yield _split("atvs", "Vehicles by what they said last.", {s: atvs[s.value] for s in AtvStatus})
        yield _split(
            "machines", "Machines by what they said last.", {s: machines[s.value] for s in MachineStatus}
        )
        yield _gauge("factory_speed_ratio", "Factory seconds per second.", projection.speed)

    def _gateway(self) -> Iterator[Metric]:
        parts = self._parts
        yield _gauge("bus_joined", "Whether the gateway is on the bus.", parts.peer.joined)
        told = CounterMetricFamily(
            "dray_gateway_messages", "Messages heard, and what came of them.", labels=("result",)
        )
        told.add_metric(("shown",), parts.projection.heard)
        told.add_metric(("ignored",), parts.projection.ignored + parts.peer.ignored)
        yield told
        silent_s = parts.presence.silent_s
        yield _gauge("strategist_present", "Whether the strategist was heard lately.", parts.presence.there)
        if silent_s is not None:
            yield _gauge("strategist_silent_seconds", "Since the strategist was heard.", silent_s)
        hub = parts.hub
        yield _gauge("stream_clients", "Panels that are open.", hub.joined)
        yield _counter("stream_frames", "Frames made for panels.", hub.frames)
        yield _counter(
            "stream_snapshots", "Snapshots given; one per panel, and more to slow ones.", hub.snapshots
        )

    def _database(self, health: Health) -> Iterator[Metric]:
        yield _gauge("database_up", "Whether the database has answered.", health.database_s is not None)
        if health.database_s is not None:
            yield _gauge("database_ping_seconds", "How long its answer took.", health.database_s)
        yield _gauge(
            "database_connections_used", "Connections in use.", self._parts.store.database.connections_used
        )


def _history(historian: Historian) -> Iterator[Metric]:
    yield _gauge("historian_up", "Whether the historian can write.", not historian.failing)
    yield _gauge("historian_waiting_events", "Events heard and not written yet.", historian.waiting)
    yield _gauge("historian_behind_seconds", "How long the oldest of them has waited.", historian.behind_s)
    yield _counter("historian_events_kept", "Events written.", historian.kept)
    yield _counter(
        "historian_events_lost",
        "Events that found the queue full, or were refused by the database.",
        historian.lost,
    )
    yield _gauge(
        "historian_numbers_missing", "Events that are known to lack and are asked for.", historian.missing
    )
    yield _counter("historian_numbers_gone", "Events that nobody has any more.", historian.gone)


def _gauge(name: str, what: str, value: float) -> Metric:
    return GaugeMetricFamily(f"dray_{name}", what, value=float(value))


def _counter(name: str, what: str, value: float) -> Metric:
    return CounterMetricFamily(f"dray_{name}", what, value=value)


def _split(name: str, what: str, values: Mapping[str, int]) -> Metric:
    family = GaugeMetricFamily(f"dray_{name}", what, labels=("status",))
    for status, value in values.items():
        family.add_metric((str(status),), value)
    return family
