"""What the panels see: the shapes of the live entities on `/api/stream` and in REST.

A view is a whole entity, replaced as a whole: the newest one wins. Times are seconds since 1970 on
the wall clock (`*_at_s`), whatever the speed of the factory's clock; durations and speeds are the
factory's own. The TypeScript types of the panels are generated from these structs.
"""

from __future__ import annotations

from typing import Literal

import msgspec


class View(msgspec.Struct, gc=False):
    """Base of everything that a panel is shown."""


class BriefView(View, kw_only=True):
    """A vehicle's part in one task."""

    task: str
    epoch: int
    role: Literal["primary", "secondary"]
    coordinator: str
    phase: str | None = None
    """approaching, loading, carrying, unloading, handing_over, returning; None for a watch."""
    item: str = ""
    quantity: int = 0
    due_at_s: float | None = None


class AtvView(View, kw_only=True):
    """An ATV, as its last heartbeat told."""

    id: str
    type: str
    status: Literal["idle", "working", "charging", "stopped", "error"]
    x_m: float
    y_m: float
    heading_rad: float
    speed_mps: float
    node: str
    way: tuple[str, ...] = ()
    """Nodes still ahead; the vehicle is between `node` and `way[0]`."""
    battery_frac: float
    load: str = ""
    load_quantity: int = 0
    link: Literal["wlan", "mesh"] = "wlan"
    via: tuple[str, ...] = ()
    """The vehicles that pass its heartbeat on, in order, when the link is mesh."""
    task: BriefView | None = None
    watches: tuple[BriefView, ...] = ()
    berth: str = ""
    speed_limit_frac: float = 1.0
    problem: str = ""
    software: str = ""
    seen_at_s: float = 0.0


class BufferView(View, kw_only=True):
    """Pieces of one item at a machine."""

    item: str
    level: int
    capacity: int
    reorder_point: int = 0
    on_order: int = 0


class GoalView(View, kw_only=True):
    """A production goal in a machine's queue."""

    goal: str
    product: str
    quantity: int
    made: int
    delivered: int


class OpenTaskView(View, kw_only=True):
    """One of a machine's open transports."""

    task: str
    epoch: int
    item: str
    quantity: int
    source: str
    destination: str
    deadline_at_s: float
    primary: str = ""
    secondary: str = ""
    round: int = 1


class MachineView(View, kw_only=True):
    """A machine, as its last heartbeat told."""

    id: str
    name: str
    status: Literal["idle", "producing", "starved", "blocked", "error"]
    product: str = ""
    goals: tuple[GoalView, ...] = ()
    tasks: tuple[OpenTaskView, ...] = ()
    buffers: tuple[BufferView, ...] = ()
    goods: tuple[BufferView, ...] = ()
    problem: str = ""
    software: str = ""
    seen_at_s: float


class BidView(View, kw_only=True):
    """A bid, with the parts of its price in seconds."""

    bidder: str
    role: Literal["primary", "secondary"]
    round: int
    total_s: float
    parts_s: dict[str, float]
    """empty_way, loaded_way, energy, suitability; or queue, material, making."""
    finish_at_s: float
    source: str = ""
    answer: str = ""
    """What came of it: empty, asked, accepted, silent, or the reason of the decline."""


class RefusalView(View, kw_only=True):
    """Who did not bid, and why."""

    agent: str
    role: Literal["primary", "secondary"]
    round: int
    reason: str
    detail: str = ""


class TaskView(View, kw_only=True):
    """A task from its announcement to its end."""

    id: str
    kind: Literal["transport", "production"]
    coordinator: str
    item: str
    quantity: int
    sources: tuple[str, ...] = ()
    source: str = ""
    """Which one the primary chose."""
    destination: str = ""
    order: str = ""
    goal: str = ""
    epoch: int = 1
    round: int = 1
    radius_m: float = 0.0
    state: Literal["bidding", "contracted", "delivered", "withdrawn"] = "bidding"
    phase: str = ""
    primary: str = ""
    secondary: str = ""
    opened_at_s: float
    contracted_at_s: float | None = None
    promised_at_s: float | None = None
    deadline_at_s: float
    closed_at_s: float | None = None
    bids: tuple[BidView, ...] = ()
    refusals: tuple[RefusalView, ...] = ()


class OrderItemView(View, kw_only=True):
    """A line of an order and how far it has come."""

    product: str
    quantity: int
    made: int = 0
    delivered: int = 0


class OrderView(View, kw_only=True):
    """An order and how far it has come."""

    id: str
    customer: str
    reference: str | None = None
    status: Literal["stored", "released", "in_production", "in_delivery", "delivered", "cancelled"]
    items: tuple[OrderItemView, ...]
    created_at_s: float
    due_at_s: float | None = None
    delivered_at_s: float | None = None


class FactoryView(View, kw_only=True):
    """The factory as a whole."""

    orders_open: int = 0
    orders_delivered: int = 0
    on_time_frac: float | None = None
    """Of the orders delivered so far; None before the first one."""
    starved_frac: float | None = None
    """Part of the machines' time with a goal in which material was missing, over the last hour."""
    transport_p50_s: float | None = None
    """From announcement to handover, over the last 200 transports, in factory seconds."""
    transport_p95_s: float | None = None
    deliveries_per_hour: tuple[float, ...] = ()
    """Transports handed over per factory hour, in the last 12 slots of 5 factory minutes, oldest first."""
    atvs_by_status: dict[str, int] = msgspec.field(default_factory=dict)
    machines_by_status: dict[str, int] = msgspec.field(default_factory=dict)
    speed: float = 1.0
    """Factory seconds per real second."""


class Snapshot(View, kw_only=True, tag_field="type", tag="snapshot"):
    """The first frame, and the answer to a gap: everything there is."""

    number: int
    at_s: float
    plant: str
    factory: FactoryView
    atvs: tuple[AtvView, ...]
    machines: tuple[MachineView, ...]
    tasks: tuple[TaskView, ...]
    """The open ones and the last 50 that closed."""
    orders: tuple[OrderView, ...]
    """The open ones and the last 50 that closed."""


class Delta(View, kw_only=True, tag_field="type", tag="delta"):
    """What has changed since the frame before: whole entities, by kind."""

    number: int
    """One more than the frame before it; a client that misses one asks for nothing: it gets a snapshot."""
    at_s: float
    factory: FactoryView | None = None
    atvs: tuple[AtvView, ...] = ()
    machines: tuple[MachineView, ...] = ()
    tasks: tuple[TaskView, ...] = ()
    orders: tuple[OrderView, ...] = ()
    gone: tuple[str, ...] = ()
    """Ids that left the stream, as `task:M8-214` or `order:...`."""
