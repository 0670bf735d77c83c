"""The frames of `/api/stream`: a snapshot of everything, then differences.

`Entities` declares the kinds of entities, once for both frames. Updates, recordings and the film of a moment take them
from there. OpenAPI documents the frames as `Snapshot` and `Delta`; the panels' TypeScript types are generated from
that.
"""

from __future__ import annotations

from typing import get_args

from msgspec.structs import fields

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


class Entities(View, kw_only=True):
    """The entities of a frame, by kind.

    All of them in a snapshot; in a delta the changed ones.
    """

    atvs: tuple[AtvView, ...] = ()
    machines: tuple[MachineView, ...] = ()
    stations: tuple[StationView, ...] = ()
    """Stations of storages."""
    tasks: tuple[TaskView, ...] = ()
    """Open tasks and the last 50 closed ones. At most 20 in a frame; later frames bring the rest."""
    orders: tuple[OrderView, ...] = ()
    """Open orders and the last 50 ended ones. At most 20 in a frame; later frames bring the rest."""
    news: tuple[NewsView, ...] = ()
    """The last 50, oldest first."""
    alerts: tuple[AlertView, ...] = ()
    """Present troubles: alarms first, and within a kind the oldest first."""
    faults: tuple[FaultView, ...] = ()
    """Faults begun by hand that have not ended."""
    commands: tuple[CommandView, ...] = ()
    """The latest commands, oldest first."""
    closures: tuple[ClosureView, ...] = ()
    """Closures in force, oldest first."""
    obstacles: tuple[ObstacleView, ...] = ()
    """Obstacles that vehicles met on lanes, oldest first."""
    waits: tuple[WaitView, ...] = ()
    """Vehicles that cannot drive on, by their ids."""
    scenarios: tuple[ScenarioView, ...] = ()
    """The scenario that the factory plays, if any; only managers see it."""


VIEWS: dict[str, type[View]] = {field.name: get_args(field.type)[0] for field in fields(Entities)}
"""Field of `Entities` -> the view of its entities."""

COLLECTIONS = {view.__name__.removesuffix("View").lower(): name for name, view in VIEWS.items()}
"""Kind of an entity, as in `Delta.gone` -> the frame's field for it. `AtvView` is the view of the kind `atv`."""


MANY = "orders", "tasks"
"""Collections that may hold thousands of entities: sent in portions."""

PORTION = 20
"""Maximum entities of each such collection per frame; later frames bring the rest. An order of 50 lines and a
task of 64 bids take some 10 kB, and a frame of them takes some milliseconds to make."""


class Snapshot(Entities, kw_only=True, tag_field="type", tag="snapshot"):
    """The first frame, and the answer to a gap: the complete state."""

    number: int
    at_s: float
    plant: str
    factory: FactoryView
    fault_injection: bool = False
    """Whether faults can be begun by hand: the factory is simulated."""
    audience: AudienceView | None = None
    """The reader of this frame; None only in a snapshot without a reader."""


class Delta(Entities, kw_only=True, tag_field="type", tag="delta"):
    """Changes since the frame before, by kind: new entities whole, known ones as id and changed fields."""

    number: int
    """One more than the frame before. A client that misses one need not ask: it gets a snapshot."""
    at_s: float
    factory: FactoryView | None = None
    gone: tuple[str, ...] = ()
    """Ids of entities that left the stream, as `task:M8-214` or `order:...`."""
