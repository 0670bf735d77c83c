"""Heartbeats: the short public status that every agent repeats (paper, 3.2: MHB and RHB).

A heartbeat is a whole state, never a difference: a lost one costs nothing but time. What has its default is left out, and what lies at a
machine is not in every one of its heartbeats (`dray.messages.heartbeat_stock`). (incarnation, seq) orders all heartbeats of one agent.
"""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated

from msgspec import UNSET, Meta, UnsetType

from dray.messages.base import (
    Count,
    Fraction,
    Id,
    IdOrNone,
    Message,
    Metres,
    MetresPerSecond,
    Part,
    Radians,
    Seconds,
    Text,
)
from dray.messages.floor.traffic import NO_RANK, Places, Rank
from dray.messages.kinds import GATES, MACHINES, STATIONS, VEHICLES
from dray.messages.link import Link, LostWlan
from dray.messages.problem import HelpWanted, Problem, StrandedGoods
from dray.messages.product import DOCUMENTS_TOLD, DocumentBrief
from dray.messages.reason import Reason


class AtvStatus(StrEnum):
    """The state machine of an ATV (paper, 3.2)."""

    IDLE = "idle"
    WORKING = "working"
    CHARGING = "charging"
    STOPPED = "stopped"
    """Held by an operator: moves again only after an acknowledge and a resume."""
    ERROR = "error"


class MachineStatus(StrEnum):
    """What a machine is doing."""

    IDLE = "idle"
    """No goal to work at."""
    PRODUCING = "producing"
    STARVED = "starved"
    """Has a goal, but material for the next cycle is missing."""
    BLOCKED = "blocked"
    """Has a goal, but its output buffer is full."""
    RESTING = "resting"  # By its working time, whatever it has to do.
    ERROR = "error"


class Role(StrEnum):
    """What a vehicle is contracted for (paper, 4.1)."""

    PRIMARY = "primary"
    SECONDARY = "secondary"


class Phase(StrEnum):
    """How far a transport has come."""

    APPROACHING = "approaching"
    """On the empty way to the source."""
    LOADING = "loading"
    """At the source: docked, or picking the load up."""
    CARRYING = "carrying"
    """On the loaded way to the destination."""
    UNLOADING = "unloading"
    """At the destination: docked, or putting the load down."""
    HANDING_OVER = "handing_over"
    """The load is down; the coordinator has not confirmed yet."""
    RETURNING = "returning"
    """Superseded with a load on board: on the way back to a storage."""


GOODS_ABOARD = frozenset({Phase.CARRYING, Phase.UNLOADING, Phase.HANDING_OVER, Phase.RETURNING})
"""Phases in which a load has left its source: goods cannot be fetched there a second time."""


class Pose(Part, frozen=True, omit_defaults=True):
    """Where a vehicle is in the plant's frame: x to the right, y up, heading from x towards y."""

    x_m: Metres
    y_m: Metres
    heading_rad: Radians


class Brief(Part, frozen=True, omit_defaults=True):
    """A vehicle's own words about one task it is contracted for."""

    task: Id
    epoch: Count
    role: Role
    coordinator: Id
    phase: Phase | None = None
    """None for a secondary: it watches."""
    item: IdOrNone = ""
    """The material or product that is carried."""
    quantity: Count = 0
    due_s: Seconds | None = None
    """When the vehicle now expects to hand over (plant clock)."""


AWAITED_MAX = 8
"""Vehicles that a heartbeat names as awaited: more than somebody goes to look for at once."""

Awaited = Annotated[tuple[Id, ...], Meta(max_length=AWAITED_MAX)]


class DockWait(Part, frozen=True, omit_defaults=True):
    """A vehicle stands at a dock that has not got ready for it in time."""

    vehicle: Id
    since_s: Seconds
    """Since when it is the next one (plant clock)."""


class OutOfService(Part, frozen=True, omit_defaults=True):
    """A person has taken an agent out of service: it takes no work."""

    by: Text
    """Who."""
    since_s: Seconds
    reason: Text = ""
    back_s: Seconds | None = None
    """When it is expected back (plant clock); None where nobody knows."""
    after_work: bool = False
    """What it carries it brings to its end first."""


class FloorBrief(Part, frozen=True, omit_defaults=True):
    """What a vehicle holds of the floor, for others' prices of ways and places to make room: a hint, and no right to anything."""

    holds: Places = ()
    stands: bool = True
    """It may not drive anywhere at present."""
    docked: bool = False
    """It stays where it stands until its work is done there."""
    waits: bool = False
    """A place that it needs is another one's, or it makes room for somebody."""
    waits_for: IdOrNone = ""
    """Who holds that place, or goes first; empty where it waits for nobody, or does not know."""
    waits_at: IdOrNone = ""
    """That place, as the table has told; empty where it has told none."""
    rank: Rank = NO_RANK
    asks_where_it_stands: bool = False
    """The place where it stands is not its own: it was put there, and asks for it before it drives anywhere."""
    removal: Count = 0
    """The newest time that it was carried away, as far as it knows (`dray.messages.floor.removal`)."""


class ProbationBrief(Part, frozen=True, omit_defaults=True):
    """How far an agent on probation has come."""

    of: Count
    """Transports that it has to do well."""
    done: Count = 0


class BodyWait(Part, frozen=True, omit_defaults=True):
    """What a vehicle's body waits for, in its driver's words."""

    what: Text
    since_s: Seconds
    """Plant clock."""
    until: Text = ""
    """What ends it; empty where the driver does not know."""


class AtvHeartbeat(Message, said_by=VEHICLES, signed="atv", frozen=True, omit_defaults=True):
    """RHB: what an ATV tells everybody (paper, 3.2).

    Idle 0.2 Hz, 1 Hz working or with a problem, and at once when the status changes.
    """

    atv: Id
    incarnation: Count
    seq: Count
    at_s: Seconds
    """When it was true, on the plant's clock."""
    status: AtvStatus
    pose: Pose
    node: Id
    """The last node that was passed."""
    speed_mps: MetresPerSecond
    battery_frac: Fraction
    battery_reckoned: bool = False
    """Its vehicle does not say how full it is: that is reckoned by time and metres."""
    load: IdOrNone = ""
    """What is on board; empty for nothing."""
    load_quantity: Count = 0
    link: Link = Link.WLAN
    via: tuple[Id, ...] = ()
    """The vehicles that passed this heartbeat on, in order, when the link is MESH."""
    lost_wlan: LostWlan | UnsetType = UNSET
    """Left out while the link is WLAN."""
    task: Brief | None = None
    """The task it is primary of: at most one (invariant 3)."""
    watches: tuple[Brief, ...] = ()
    """The tasks it is secondary of."""
    way: tuple[Id, ...] = ()
    """The nodes still ahead, in order; empty when it stands."""
    dwell_point: IdOrNone = ""
    """The charger or parking place that it holds or is driving to."""
    speed_limit_frac: Fraction = 1.0
    """An operator's limit, as a part of the vehicle's own top speed."""
    acknowledged: bool = False
    """Somebody has said that the reason of its stop is gone: a resume will be obeyed."""
    problem: Text = ""
    """What keeps it in ERROR, in words; empty otherwise."""
    about_problem: Problem | UnsetType = UNSET
    """What is known of that problem; left out where there is none, or nothing is known."""
    body_wait: BodyWait | UnsetType = UNSET
    """Left out where its body waits for nothing, has begun to wait only just, or does not tell."""
    help: HelpWanted | None = None
    """Set while a person could still save the task."""
    software: Text = ""
    draining: bool = False
    """It was asked to leave: it takes nothing new, and goes when nothing holds it any more."""
    out_of_service: OutOfService | UnsetType = UNSET
    """Left out while it is in service."""
    sent_to_charge: bool = False
    """A person has sent it to charge: it takes no work before it is full."""
    probation: ProbationBrief | None = None
    """Set while it is on probation: it takes short tasks only."""
    floor: FloorBrief | UnsetType = UNSET
    """Left out where vehicles drive without right of way."""
    closures: Count | UnsetType = UNSET
    """The number of the list of closures that it goes by; left out where it has heard of none."""


class BufferLevel(Part, frozen=True, omit_defaults=True):
    """One material in front of a machine, or its finished goods."""

    item: Id
    level: Count
    capacity: Count
    reorder_point: Count = 0
    """The level at which the machine asks for more; 0 for finished goods."""
    on_order: Count = 0
    """Pieces announced and not yet handed over."""
    spare: Count = 0
    """Finished pieces that belong to no goal: the next one of the product takes them, and whoever needs a part fetches it."""


class TaskBrief(Part, frozen=True, omit_defaults=True):
    """A coordinator's own words about one of its open tasks."""

    task: Id
    epoch: Count
    item: Id
    quantity: Count
    source: IdOrNone
    """The storage the primary chose; empty while nobody is contracted."""
    destination: Id
    deadline_s: Seconds
    primary: IdOrNone = ""
    secondary: IdOrNone = ""
    round: Count = 1
    """The bidding round it is in or was contracted in: a high one means that the machine waits."""
    trouble: Reason | None = None
    """Why it does not go on; None when all is well. `PROBLEM` of its carrier, which `detail` tells; or it has failed with goods on board."""
    detail: Text = ""
    stranded: StrandedGoods | UnsetType = UNSET


class GoalBrief(Part, frozen=True, omit_defaults=True):
    """A machine's own words about one production goal. Counts only ever grow."""

    goal: Id
    product: Id
    quantity: Count
    made: Count
    delivered: Count
    deadline_s: Seconds | UnsetType = UNSET
    """When it should be done (plant clock); left out where a software does not tell."""
    offered: bool | UnsetType = UNSET
    """Others may make what is missing: nothing is made, ready or on its way. Left out where that is not so."""
    to_begin: Count | UnsetType = UNSET
    """Pieces whose material no cycle has taken; left out where those are the ones not made."""
    held: Count | UnsetType = UNSET
    """With which epoch its order is held by the strategist whom the machine obeys; left out where nobody has taken it over."""


class Making(Part, frozen=True, omit_defaults=True):
    """A product that a machine can make."""

    product: Id
    cycle_s: Seconds


JOINING_MACHINES_MAX = 100
"""Machines that may come to a plant whose file does not know them: more than anybody sets up before writing them into it."""


class JoiningMachine(Part, frozen=True, omit_defaults=True):
    """What a machine tells of itself that the plant files of others do not know yet."""

    name: Text
    station: Id
    node: Id
    """Where vehicles dock."""
    x_m: Metres
    y_m: Metres
    """Its middle; with its size, for drawing."""
    width_m: Metres
    depth_m: Metres
    makes: tuple[Making, ...]
    goods_capacity: Count


class MaterialWait(Part, frozen=True, omit_defaults=True):
    """Material that a machine needs, and for which nobody is hired because it is nowhere to be fetched."""

    item: Id
    quantity: Count
    short: tuple[Id, ...] = ()
    """Storages whose stations have said that they have too little."""
    silent: tuple[Id, ...] = ()
    """Storages whose stations do not answer."""
    since_s: Seconds = 0.0

    def told(self, name: str) -> str:
        """In words, with the material's name: "rotor (storage S3 has none)"."""
        reasons = [
            f"{_storages(places)} {one if len(places) == 1 else several}"
            for places, one, several in (
                (self.short, "has none", "have none"),
                (self.silent, "does not answer", "do not answer"),
            )
            if places
        ]
        return f"{name} ({' and '.join(reasons)})" if reasons else name


def _storages(places: tuple[str, ...]) -> str:
    return f"storage{'s' if len(places) > 1 else ''} {', '.join(places)}"


class StockLevel(Part, frozen=True, omit_defaults=True):
    """One material in a storage."""

    item: Id
    level: Count
    capacity: Count
    promised: Count = 0
    """Pieces of `level` that are set aside for tasks; never more than lie there."""
    wanted: Count = 0
    """Pieces that are asked for and cannot be promised yet."""
    on_order: Count = 0
    """Pieces that are on their way here, or are to be."""
    uncounted: bool = False
    """Nobody knows how many lie there, until somebody has counted: at least `level`."""


class UnconfirmedLoad(Part, frozen=True, omit_defaults=True):
    """A load that a vehicle says it has brought or taken, and that people have not confirmed yet."""

    vehicle: Id
    item: Id
    quantity: Count
    goes: bool = False
    """It was taken away; else it was brought."""


LOADS_TOLD = 8
"""Unconfirmed loads in a heartbeat: more than people confirm at one look."""


class GoalToCome(Part, frozen=True, omit_defaults=True):
    """Pieces of a goal that the gate lets in, and of which people have not said that they have arrived."""

    goal: Id
    quantity: Count


GOALS_TOLD = 50
"""Goals in a heartbeat of the gate: more than somebody looks through. Others are known by the codes of their labels."""


class PeopleAsBody(Part, frozen=True, omit_defaults=True):
    """An agent's body is people: what they say is counted."""

    loads: Annotated[tuple[UnconfirmedLoad, ...], Meta(max_length=LOADS_TOLD)] = ()
    """Unconfirmed ones, the oldest first."""
    goals: Annotated[tuple[GoalToCome, ...], Meta(max_length=GOALS_TOLD)] = ()
    """Of the gate: what is to come, the quietest first."""


class StationHeartbeat(Message, said_by=STATIONS | GATES, signed="station", frozen=True, omit_defaults=True):
    """What the agent of a storage or source warehouse tells everybody, at 0.2 Hz and when it changes: what lies there, what is promised."""

    station: Id
    incarnation: Count
    seq: Count
    at_s: Seconds
    stocks: tuple[StockLevel, ...] = ()
    """In the order of the plant file."""
    tasks: tuple[TaskBrief, ...] = ()
    waits: tuple[MaterialWait, ...] = ()
    software: Text = ""
    draining: bool = False
    awaits: Awaited | UnsetType = UNSET
    """Vehicles without whose word it grants no place of a reservation table that was lost; of more than `AWAITED_MAX` the first."""
    dock_wait: DockWait | UnsetType = UNSET
    """Left out while its dock gets ready for everybody in time."""
    people: PeopleAsBody | UnsetType = UNSET
    """Left out where its body is not people."""


class MachineHeartbeat(Message, said_by=MACHINES, signed="machine", frozen=True, omit_defaults=True):
    """MHB: what a machine tells everybody (paper, 3.2).

    Idle 0.2 Hz, 1 Hz working or with a problem, and at once when the status changes. A goal stays in `goals` until the strategist has closed it, who so misses nothing.
    """

    machine: Id
    incarnation: Count
    seq: Count
    at_s: Seconds
    status: MachineStatus
    product: IdOrNone = ""
    """What is being made now; empty for nothing."""
    goals: tuple[GoalBrief, ...] = ()
    """In the order in which they are worked at."""
    tasks: tuple[TaskBrief, ...] = ()
    buffers: tuple[BufferLevel, ...] | UnsetType = UNSET
    """In the order of the plant file. They, goods and documents are left out while as in an earlier heartbeat (`dray.messages.heartbeat_stock`)."""
    goods: tuple[BufferLevel, ...] | UnsetType = UNSET
    """Finished products that wait to be carried away."""
    documents: Annotated[tuple[DocumentBrief, ...], Meta(max_length=DOCUMENTS_TOLD)] | UnsetType = UNSET
    waits: tuple[MaterialWait, ...] = ()
    """What it needs and cannot have fetched, the oldest first."""
    problem: Text = ""
    """What keeps it in ERROR, in words; empty otherwise."""
    about_problem: Problem | UnsetType = UNSET
    """What is known of that problem; left out where there is none, or nothing is known."""
    resettable: bool | UnsetType = UNSET
    """Its sensors find nothing wrong any more, and it waits for somebody to say so. Left out where that is not so."""
    help: HelpWanted | UnsetType = UNSET
    """Set while a person could still save its goals."""
    out_of_service: OutOfService | UnsetType = UNSET
    """Left out while it is in service."""
    speed_frac: Fraction | UnsetType = UNSET
    """A person's limit, as a part of its own speed; left out where there is none."""
    software: Text = ""
    draining: bool = False
    """It was asked to leave: it takes nothing new, and goes when nothing holds it any more."""
    probation: ProbationBrief | None = None
    """Set while it is on probation: it takes short goals only."""
    joining: JoiningMachine | None = None
    """Set when it has come to a plant whose file did not know it."""
    people: PeopleAsBody | UnsetType = UNSET
    """Left out where its body is not people."""
    awaits: Awaited | UnsetType = UNSET
    """Vehicles without whose word it grants no place of a reservation table that was lost; of more than `AWAITED_MAX` the first."""
    dock_wait: DockWait | UnsetType = UNSET
    """Left out while its dock gets ready for everybody in time."""
