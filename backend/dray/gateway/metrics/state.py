"""State: values of other parts, read when Prometheus asks."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from prometheus_client import Metric
from prometheus_client.registry import Collector

from dray.adapters.telemetry.metric_families import counter, counters, gauge, gauges
from dray.gateway.live.health import Health
from dray.gateway.live.peer import Peer
from dray.gateway.live.projection import Projection
from dray.gateway.live.strategist_probe import StrategistProbe
from dray.gateway.live.stream import Hub
from dray.messages import AtvStatus, MachineStatus
from dray.store import Store
from dray.store.orders.progress import OPEN, OrderStatus
from dray.supervision import Supervisor


class State(Collector):
    """Reads other parts' values.

    Args:
        projection: the factory as panels see it.
        hub: the open panels.
        peer: the connection to the bus.
        strategist_probe: tells when the strategist was heard.
        health: tells how the database answers.
        store: the database.
        supervisor: supervises the gateway's tasks.
        wall_s: the wall clock.
    """

    def __init__(
        self,
        *,
        projection: Projection,
        hub: Hub,
        peer: Peer,
        strategist_probe: StrategistProbe,
        health: Health,
        store: Store,
        supervisor: Supervisor,
        wall_s: Callable[[], float],
    ) -> None:
        self._projection, self._hub, self._peer = projection, hub, peer
        self._strategist_probe, self._health = strategist_probe, health
        self._store, self._supervisor, self._wall_s = store, supervisor, wall_s

    def collect(self) -> Iterator[Metric]:
        """The present values."""
        yield from self._factory()
        yield from self._gateway()
        yield from self._database(self._health)

    def _factory(self) -> Iterator[Metric]:
        projection = self._projection
        open_orders = projection.orders.by_status
        yield gauges(
            "orders_open",
            "Orders that have not ended.",
            "status",
            {s: open_orders[s] for s in (OrderStatus.STORED, *OPEN)},
        )
        yield gauge("orders_delivered", "Orders that were ever delivered.", projection.orders.delivered)
        yield gauge("orders_delivered_on_time", "Of these, by their due time.", projection.orders.on_time)
        atvs, machines = projection.atvs.by_status, projection.machines.by_status
        yield gauges(
            "atvs", "Vehicles by what they said last.", "status", {s: atvs[s.value] for s in AtvStatus}
        )
        yield gauges(
            "machines",
            "Machines by what they said last.",
            "status",
            {s: machines[s.value] for s in MachineStatus},
        )
        ahead_s = [offset.ahead_s for offset in projection.clocks.offsets().values()]
        yield gauges(
            "agents_clock_ahead_seconds",
            "How far the clocks of agents are ahead, behind if negative, as their heartbeats show it.",
            "extreme",
            {"first": max(ahead_s, default=0.0), "last": min(ahead_s, default=0.0)},
        )
        now_s = projection.plant_s(self._wall_s())
        wrong = sum(1 for _ in projection.clocks.wrong(now_s))
        yield gauge("agents_clock_wrong", "Agents whose clocks are wrong beyond doubt.", wrong)
        yield counter(
            "strangers_heartbeats",
            "Heartbeats of names that are not of this plant, beyond those that may have joined.",
            projection.atvs.strangers + projection.machines.strangers,
        )
        yield gauge("factory_speed_ratio", "Factory seconds per second.", projection.speed)

    def _gateway(self) -> Iterator[Metric]:
        yield gauge("bus_joined", "Whether the gateway is on the bus.", self._peer.joined)
        yield counters(
            "gateway_messages",
            "Messages heard, and what came of them.",
            "result",
            {"shown": self._projection.heard, "ignored": self._projection.ignored + self._peer.ignored},
        )
        yield counters(
            "gateway_task_restarts",
            "Failures of tasks of the gateway, each of which was started again; the log has the reason.",
            "task",
            self._supervisor.restarts,
        )
        silent_s = self._strategist_probe.silent_s
        presence = self._strategist_probe.presence()
        yield gauge("strategist_present", "Whether any strategist was heard lately.", any(presence.values()))
        yield gauges("strategists_present", "Whether each of them was.", "strategist", presence)
        if silent_s is not None:
            yield gauge("strategist_silent_seconds", "Since any strategist was heard.", silent_s)
        hub = self._hub
        yield gauge("stream_clients", "Panels that are open.", hub.joined)
        yield counter("stream_frames", "Frames made for panels.", hub.frames)
        yield counter(
            "stream_snapshots", "Snapshots given; one per panel, and more to slow ones.", hub.snapshots
        )

    def _database(self, health: Health) -> Iterator[Metric]:
        yield gauge("database_up", "Whether the database has answered.", health.database_s is not None)
        if health.database_s is not None:
            yield gauge("database_ping_seconds", "How long its answer took.", health.database_s)
        yield gauge("database_connections_used", "Connections in use.", self._store.database.connections_used)
