"""The frames of `/api/stream`: a snapshot of everything, then differences.

OpenAPI tells of them as `Snapshot` and `Delta`; the panels' TypeScript types are generated from that document.
"""

from __future__ import annotations

from dray.gateway.live.views import (
    AlertView,
    AtvView,
    AudienceView,
    ClosureView,
    CommandView,
    FactoryView,
    FaultView,
    MachineView,
    NewsView,
    ObstacleView,
    OrderView,
    ScenarioView,
    StationView,
    TaskView,
    View,
    WaitView,
)


class Snapshot(View, kw_only=True, tag_field="type", tag="snapshot"):
    """The first frame, and the answer to a gap: everything there is."""

    number: int
    at_s: float
    plant: str
    factory: FactoryView
    atvs: tuple[AtvView, ...]
    machines: tuple[MachineView, ...]
    stations: tuple[StationView, ...] = ()
    """Of storages."""
    tasks: tuple[TaskView, ...]
    """The open ones and the last 50 that closed; of many the first 20, and the others in the frames that follow."""
    orders: tuple[OrderView, ...]
    """The open ones and the last 50 that ended; of many the first 20, and the others in the frames that follow."""
    news: tuple[NewsView, ...] = ()
    """The last 50, oldest first."""
    alerts: tuple[AlertView, ...] = ()
    """What is wrong now: alarms first, and of one kind the oldest first."""
    fault_injection: bool = False
    """Whether faults can be begun by hand: the factory is simulated."""
    faults: tuple[FaultView, ...] = ()
    """Those that were begun by hand and have not ended."""
    commands: tuple[CommandView, ...] = ()
    """The last ones, oldest first."""
    closures: tuple[ClosureView, ...] = ()
    """Those that hold, oldest first."""
    obstacles: tuple[ObstacleView, ...] = ()
    """What vehicles have met on lanes, oldest first."""
    waits: tuple[WaitView, ...] = ()
    """Vehicles that cannot drive on, by their ids."""
    scenarios: tuple[ScenarioView, ...] = ()
    """The one that the factory plays, where it does; managers alone see it."""
    audience: AudienceView | None = None
    """Whoever reads this; None only in a snapshot that is nobody's."""


COLLECTIONS = {
    "atv": "atvs",
    "machine": "machines",
    "station": "stations",
    "task": "tasks",
    "order": "orders",
    "news": "news",
    "alert": "alerts",
    "fault": "faults",
    "command": "commands",
    "closure": "closures",
    "obstacle": "obstacles",
    "wait": "waits",
    "scenario": "scenarios",
}
"""Kind of an entity, as in `Delta.gone` -> where a frame tells of them."""


MANY = "orders", "tasks"
"""Collections of which there may be thousands: they are told in portions."""

PORTION = 20
"""So many of each are in one frame at most: a snapshot is followed by others with the rest. An order of 50 lines and a task of 64 bids take some
10 kB; what makes a frame of them takes some milliseconds."""


class Delta(View, kw_only=True, tag_field="type", tag="delta"):
    """What has changed since the frame before, by kind: new entities whole, of others the id and the fields that have changed."""

    number: int
    """One more than the frame before it; a client that misses one asks for nothing: it gets a snapshot."""
    at_s: float
    factory: FactoryView | None = None
    atvs: tuple[AtvView, ...] = ()
    machines: tuple[MachineView, ...] = ()
    stations: tuple[StationView, ...] = ()
    tasks: tuple[TaskView, ...] = ()
    orders: tuple[OrderView, ...] = ()
    news: tuple[NewsView, ...] = ()
    alerts: tuple[AlertView, ...] = ()
    faults: tuple[FaultView, ...] = ()
    commands: tuple[CommandView, ...] = ()
    closures: tuple[ClosureView, ...] = ()
    obstacles: tuple[ObstacleView, ...] = ()
    waits: tuple[WaitView, ...] = ()
    scenarios: tuple[ScenarioView, ...] = ()
    gone: tuple[str, ...] = ()
    """Ids that left the stream, as `task:M8-214` or `order:...`."""
