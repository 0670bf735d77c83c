"""What the panels see: the shapes of the live entities on `/api/stream` (`dray.gateway.frames`) and in REST.

A view is a whole entity, replaced as a whole: the newest one wins. Times are seconds since 1970 on
the wall clock (`*_at_s`), whatever the speed of the factory's clock; durations and speeds are the
factory's own. The TypeScript types of the panels are generated from these structs.

Whoever is limited to areas is shown less of an entity, and `*` in place of a vehicle that stands elsewhere
(`dray.gateway.projection.sight`).
"""

from __future__ import annotations

from typing import Any, Literal

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


class HelpView(View, kw_only=True):
    """A problem that a person can solve, while its task waits for that."""

    until_at_s: float
    """Solved by then, the vehicle goes on; else somebody else takes its task."""
    promised_by: str = ""
    """Who has said to be on the way; empty while nobody has."""


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
    acknowledged: bool = False
    """While it is stopped: somebody has said that the reason is gone, and it may be resumed."""
    problem: str = ""
    help: HelpView | None = None
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
    trouble: str = ""
    """Why it does not go on, in the machine's words; empty when all is well."""


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
    epoch: int = 1
    round: int
    total_s: float
    parts_s: dict[str, float]
    """empty_way, loaded_way, energy, suitability; or queue, material, making."""
    finish_at_s: float
    source: str = ""
    answer: str = ""
    """What came of it: empty, asked, accepted, silent, or the reason of the decline."""
    taken_for: str = ""
    """For whom the bidder worked already when it declined because it was busy; empty where nobody knows."""


class RefusalView(View, kw_only=True):
    """Who did not bid, and why."""

    agent: str
    role: Literal["primary", "secondary"]
    epoch: int = 1
    round: int
    reason: str
    detail: str = ""


class CarrierView(View, kw_only=True):
    """Who carried a task from when on, or that it was put up for auction again."""

    carrier: str
    """Empty when it was announced anew."""
    epoch: int
    since_at_s: float
    how: Literal["won", "took_over", "adopted", "announced_anew"] = "won"
    """Won the auction, took over from the one that it watched, or was found to carry it by a coordinator
    that had been away."""
    replaced: str = ""
    """Who carried it before; empty for the first one."""
    reason: str = ""
    """Why `replaced` does not carry it any more."""
    silent_s: float = 0.0
    """How long nothing had been heard of the one before, in factory seconds."""
    confirmed: bool = True
    """False while only the carrier itself says so, and the coordinator has not."""


class PassedView(View, kw_only=True):
    """A bidder that would have come before the one that was chosen, and why it was passed over."""

    agent: str
    less_s: float
    """How much less it had bid."""
    answer: str
    """silent, late (its bid came after the window), asked (no answer is on record), or why it declined."""
    taken_for: str = ""
    """For whom it worked already when it declined because it was busy; empty where nobody knows."""


class RefusedView(View, kw_only=True):
    """Those who did not bid, by their reason."""

    reason: str
    agents: tuple[str, ...]


class WhyView(View, kw_only=True):
    """Why this contractor: the parts of the sentence, for other languages, and the sentence itself."""

    kind: Literal[
        "waiting",
        "leading",
        "asked",
        "only",
        "cheapest",
        "tie",
        "took_over",
        "adopted",
        "unknown",
        "withdrawn",
    ]
    """waiting: nobody has bid; leading, asked: the cheapest bid so far; only: nobody else bid; unknown: no
    bid of its carrier is on record."""
    agent: str = ""
    """Whom it is about: the carrier, else the cheapest bidder, else the coordinator."""
    total_s: float = 0.0
    """Its price."""
    bidders: int = 0
    """How many bid."""
    left: int = 0
    """How many of them were left to choose from: neither passed over nor asked in vain."""
    other: str = ""
    """The next cheapest one of those."""
    by_s: float = 0.0
    """How much more that one wanted."""
    part: str = ""
    """The part of the price that makes most of the difference; empty where none does."""
    part_s: float = 0.0
    """The difference in that part."""
    tie_by: Literal["", "price", "finish", "name"] = ""
    """What decided between equal prices: less than is shown, who is done earlier, or the order of names."""
    passed: tuple[PassedView, ...] = ()
    """Cheapest first."""
    refused: tuple[RefusedView, ...] = ()
    """The most frequent reason first."""
    round: int = 0
    """How many rounds it took, or has taken so far."""
    radius_m: float = 0.0
    """How far the last of them reached; 0 where distance does not matter."""
    replaced: str = ""
    """Who carried it before."""
    reason: str = ""
    """Why that one does not any more."""
    silent_s: float = 0.0
    """How long nothing had been heard of that one, in factory seconds."""
    confirmed: bool = True
    """False for a takeover that the coordinator has not confirmed."""
    coordinator: str = ""
    text: str = ""
    """All of it in one English sentence or two."""


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
    trouble: str = ""
    """Why it does not go on, in its coordinator's words; empty when all is well."""
    carriers: tuple[CarrierView, ...] = ()
    """Oldest first."""
    bids: tuple[BidView, ...] = ()
    refusals: tuple[RefusalView, ...] = ()
    why: WhyView = msgspec.field(default_factory=lambda: WhyView(kind="waiting"))
    """Why this contractor, or why nobody yet; true to the bids that were heard."""


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
    releases: int = 0
    """How often it was released."""
    revoked_at_s: float | None = None
    """When its last release was taken back. Until `status` is `stored` the factory has not confirmed that."""
    waits: str = ""
    """Why it waits: nobody who lives can make what is missing, say; empty when it goes on."""


class NewsView(View, kw_only=True):
    """Something that people should know of without looking for it: a failure, and what became of it."""

    id: str
    kind: Literal[
        "took_over",
        "takeover_refused",
        "announced_anew",
        "link_lost",
        "link_back",
        "help_asked",
        "help_promised",
        "goal_lost",
        "goal_waits",
    ]
    at_s: float
    """Wall clock, as all times of views."""
    agent: str
    """Whom it is about: the vehicle or machine to look at."""
    other: str = ""
    """Whom `agent` has replaced; or who has promised to help."""
    task: str = ""
    epoch: int = 0
    goal: str = ""
    successor: str = ""
    """The goal under which what is missing of `goal` goes on; empty when nothing is."""
    arrived: int = 0
    """Pieces of `goal` that had been delivered, and count."""
    order: str = ""
    reason: str = ""
    silent_s: float = 0.0
    """How long nothing had been heard of `other`, in factory seconds."""
    until_at_s: float | None = None
    """How long help is waited for."""
    confirmed: bool = True
    """False for a takeover that the task's coordinator has not confirmed."""


AlertKind = Literal[
    "machine_lost",
    "machine_error",
    "atv_lost",
    "atv_help",
    "atv_error",
    "order_waits",
    "order_late",
    "machine_starved",
    "machine_blocked",
    "task_trouble",
    "atv_promised",
    "atv_stopped",
    "atv_battery",
]
"""What can be wrong; graver kinds first."""

AlertResponse = Literal[
    "look_at_machine",
    "repair",
    "see_to_supply",
    "see_to_removal",
    "find_vehicle",
    "promise_help",
    "help",
    "resume",
    "bring_to_charger",
    "look_at_auction",
    "restore_machines",
    "tell_customer",
]
"""What an alert asks of people."""


class AlertView(View, kw_only=True):
    """Something that is wrong now, and what it asks of people. It leaves when its cause is gone."""

    id: str
    kind: AlertKind
    level: Literal["alarm", "warning"]
    response: AlertResponse
    since_at_s: float
    agent: str = ""
    """The machine or vehicle that it is about; of a transport, who carries it. Empty for an order."""
    task: str = ""
    order: str = ""
    problem: str = ""
    """In the agent's own words, where it has any."""
    by: str = ""
    """Who is on the way to help."""
    seen_at_s: float | None = None
    """Of who is lost: when it was last heard."""
    until_at_s: float | None = None
    """How long help is waited for, or when the order was due."""
    battery_frac: float | None = None
    acknowledged_by: str = ""
    """The name of who has taken it on; empty while nobody has."""
    acknowledged_at_s: float | None = None


CommandState = Literal["sent", "confirmed", "refused", "not_confirmed"]


class CommandView(View, kw_only=True):
    """What a person has asked of a vehicle, and the vehicle's word on it."""

    id: str
    """As whoever gave it has named it, else as the gateway has."""
    atv: str
    kind: Literal["stop", "acknowledge", "resume", "set_speed", "promise"]
    speed_frac: float | None = None
    by: str
    """The name of who gave it."""
    at_s: float
    """When."""
    state: CommandState = "sent"
    """not_confirmed: the vehicle has said nothing in time; it may or may not have heard."""
    reason: str = ""
    """Why the vehicle has refused it."""


class AudienceView(View, kw_only=True):
    """Who is shown the stream, and how much of it."""

    role: Literal["manager", "operator", ""]
    """Empty for other systems and the administrator."""
    name: str
    areas: tuple[str, ...] | None = None
    """Only what is in these areas is shown; None for the whole plant."""
    station: str = ""
    """The machine at which an operator works."""


class FaultView(View, kw_only=True):
    """A fault that was begun by hand in a simulated factory, and has not ended."""

    id: str
    kind: str
    fault: dict[str, Any]
    """As it was begun: its `kind` and its fields."""
    agents: tuple[str, ...]
    """Whom it is about; empty where it is about the network as a whole."""
    began_at_s: float


class UseView(View, kw_only=True):
    """What the fleet's time of the last hour was spent on, in parts that add up to 1."""

    moving: float
    waiting: float
    """At work, and standing: while loading and unloading, or for lack of a way."""
    charging: float
    blocked: float
    """Stopped by a person, or in error."""
    idle: float
    silent: float
    """Not heard for longer than 15 factory seconds."""


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
    empty_frac: float | None = None
    """Part of the fleet's way in the last hour of factory time that was driven without a load."""
    use: UseView | None = None
    """None before the first vehicle was heard for a while, as for the two below."""
    atv_available_frac: float | None = None
    """Part of the vehicles' time of the last hour in which they were heard and neither stopped nor in error."""
    machine_available_frac: float | None = None
    """Part of the machines' time of the last hour in which they were heard and not in error."""
    commands: int = 0
    """People's commands that vehicles have obeyed in the last hour."""
    helps: int = 0
    """How often vehicles have asked for help in the last hour."""
    deliveries_per_hour: tuple[float, ...] = ()
    """Transports handed over per factory hour, in the last 12 slots of 5 factory minutes, oldest first."""
    atvs_by_status: dict[str, int] = msgspec.field(default_factory=dict)
    machines_by_status: dict[str, int] = msgspec.field(default_factory=dict)
    speed: float = 1.0
    """Factory seconds per real second."""
