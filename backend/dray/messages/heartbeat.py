"""Heartbeats: the short public status that every agent repeats (paper, 3.2: MHB and RHB).

A heartbeat is a whole state, never a difference, so a lost one only costs time. Default values are left out. A machine's stock is
only in some of its heartbeats (`dray.messages.heartbeat_stock`). (incarnation, seq) orders all heartbeats of one agent.
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
    """Stopped by an operator: it moves again only after an acknowledge and a resume."""
    ERROR = "error"


class MachineStatus(StrEnum):
    """What a machine is doing."""

    IDLE = "idle"
    """No goal to work at."""
    PRODUCING = "producing"
    STARVED = "starved"
    """It has a goal, but material for the next cycle is missing."""
    BLOCKED = "blocked"
    """It has a goal, but its output buffer is full."""
    RESTING = "resting"  # Outside its working time, even with goals.
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
"""Phases in which the load has left its source: it cannot be fetched there again."""


class Pose(Part, frozen=True, omit_defaults=True):
    """A vehicle's pose in the plant's frame: x to the right, y up, heading from x towards y."""

    x_m: Metres
    y_m: Metres
    heading_rad: Radians


class Brief(Part, frozen=True, omit_defaults=True):
    """A vehicle's report of one task it is contracted for."""

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
"""Maximum vehicles that a heartbeat names as awaited: more than a person looks for at once."""

Awaited = Annotated[tuple[Id, ...], Meta(max_length=AWAITED_MAX)]


class DockWait(Part, frozen=True, omit_defaults=True):
    """A vehicle waits at a dock that did not get ready in time."""

    vehicle: Id
    since_s: Seconds
    """Since when it is the next one (plant clock); earlier by the waits of others that gave up since the dock last opened."""


class OutOfService(Part, frozen=True, omit_defaults=True):
    """A person has taken an agent out of service: it takes no work."""

    by: Text
    """The person."""
    since_s: Seconds
    reason: Text = ""
    back_s: Seconds | None = None
    """When it is expected back (plant clock); None when unknown."""
    after_work: bool = False
    """Whether it finishes its present work first."""


class FloorBrief(Part, frozen=True, omit_defaults=True):
    """A vehicle's places on the floor: a hint for others' prices of ways and refuges, which grants no rights."""

    holds: Places = ()
    stands: bool = True
    """Whether it may not drive anywhere at present."""
    docked: bool = False
    """Whether it stays where it stands until its work there is done."""
    waits: bool = False
    """Whether it waits for a place, or makes room for another vehicle."""
    waits_for: IdOrNone = ""
    """The vehicle that holds that place, or goes first; empty when it waits for none, or does not know."""
    waits_at: IdOrNone = ""
    """That place, by the table's answer; empty when the answer names none."""
    rank: Rank = NO_RANK
    asks_where_it_stands: bool = False
    """Whether it does not hold the place where it stands: it was put there, and requests that place before it drives."""
    removal: Count = 0
    """Number of its newest removal, as far as it knows (`dray.messages.floor.removal`)."""


class ProbationBrief(Part, frozen=True, omit_defaults=True):
    """The progress of an agent on probation."""

    of: Count
    """Transports that it has to complete well."""
    done: Count = 0


class BodyWait(Part, frozen=True, omit_defaults=True):
    """What a vehicle's body waits for, in the words of its driver software."""

    what: Text
    since_s: Seconds
    """Plant clock."""
    until: Text = ""
    """What ends the wait; empty when the driver does not know."""


class AtvHeartbeat(Message, said_by=VEHICLES, signed="atv", frozen=True, omit_defaults=True):
    """RHB: the public state of an ATV (paper, 3.2).

    At 0.2 Hz while idle, at 1 Hz while working or with a problem, and at once when the status changes.
    """

    atv: Id
    incarnation: Count
    seq: Count
    at_s: Seconds
    """Time of this state (plant clock)."""
    status: AtvStatus
    pose: Pose
    node: Id
    """The last node that was passed."""
    speed_mps: MetresPerSecond
    battery_frac: Fraction
    battery_reckoned: bool = False
    """Whether the battery level is estimated from time and metres, as the vehicle does not measure it."""
    load: IdOrNone = ""
    """What is on board; empty for nothing."""
    load_quantity: Count = 0
    left_empty: IdOrNone = ""
    """The node where it has lost its memory, and which it has left since with nothing on board; empty for none, and once it
    stands there again."""
    link: Link = Link.WLAN
    via: tuple[Id, ...] = ()
    """The vehicles that have forwarded this heartbeat, in order, when the link is MESH."""
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
    """An operator's limit, as a fraction of the vehicle's top speed."""
    acknowledged: bool = False
    """Whether a person has confirmed that the reason of its stop is gone, so that a resume will be obeyed."""
    problem: Text = ""
    """What keeps it in ERROR, in words; empty otherwise."""
    about_problem: Problem | UnsetType = UNSET
    """Details of that problem; left out when there is none, or nothing is known."""
    body_wait: BodyWait | UnsetType = UNSET
    """Left out when its body does not wait, has only just begun to wait, or does not report it."""
    help: HelpWanted | None = None
    """Set while a person could still save the task."""
    software: Text = ""
    draining: bool = False
    """Whether it was asked to shut down: it takes no new work, and stops when nothing holds it any more."""
    out_of_service: OutOfService | UnsetType = UNSET
    """Left out while it is in service."""
    sent_to_charge: bool = False
    """Whether a person has sent it to charge: it takes no work until it is full."""
    in_reserve: bool = False
    """Whether it belongs to the reserve of a fleet that is too large for its floor: it takes only work that others cannot do."""
    probation: ProbationBrief | None = None
    """Set while it is on probation: it takes short tasks only."""
    floor: FloorBrief | UnsetType = UNSET
    """Left out in plants without right of way."""
    closures: Count | UnsetType = UNSET
    """Number of the list of closures that it obeys; left out without one."""


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
    """Finished pieces without a goal: the product's next goal takes them, and machines that need a part fetch them."""


class TaskBrief(Part, frozen=True, omit_defaults=True):
    """A coordinator's report of one of its open tasks."""

    task: Id
    epoch: Count
    item: Id
    quantity: Count
    source: IdOrNone
    """The storage that the primary has chosen; empty while none is contracted."""
    destination: Id
    deadline_s: Seconds
    primary: IdOrNone = ""
    secondary: IdOrNone = ""
    round: Count = 1
    """The present bidding round, or the one of its contract: a high one means that the machine waits."""
    trouble: Reason | None = None
    """Why it does not go on; None when all is well. `PROBLEM`: its carrier reports one (`detail`), or failed with goods on board."""
    detail: Text = ""
    stranded: StrandedGoods | UnsetType = UNSET
    fails_at: IdOrNone = ""
    """With `DISPUTED`: the place where carriers have failed to load or unload it, and where a person is asked to look."""


class GoalBrief(Part, frozen=True, omit_defaults=True):
    """A machine's report of one production goal. Counts only grow."""

    goal: Id
    product: Id
    quantity: Count
    made: Count
    delivered: Count
    deadline_s: Seconds | UnsetType = UNSET
    """When it should be done (plant clock); left out when the software does not fill it."""
    offered: bool | UnsetType = UNSET
    """Whether others may make the missing pieces, as none is in work, ready or on its way; left out when they may not."""
    to_begin: Count | UnsetType = UNSET
    """Pieces whose material no cycle has taken; left out when these are all pieces not made yet."""
    held: Count | UnsetType = UNSET
    """Epoch under which the strategist that the machine obeys holds the order; left out while none has taken it over."""
    holder: Id | UnsetType = UNSET
    """That strategist; left out like `held`."""


class Making(Part, frozen=True, omit_defaults=True):
    """A product that a machine can make."""

    product: Id
    cycle_s: Seconds


JOINING_MACHINES_MAX = 100
"""Maximum machines outside the plant file: more than people set up before they write them into it."""


class JoiningMachine(Part, frozen=True, omit_defaults=True):
    """The data of a machine that the plant files of others do not contain yet."""

    name: Text
    station: Id
    node: Id
    """The node where vehicles dock."""
    x_m: Metres
    y_m: Metres
    """Its centre; with its size, for drawing."""
    width_m: Metres
    depth_m: Metres
    makes: tuple[Making, ...]
    goods_capacity: Count


class MaterialWait(Part, frozen=True, omit_defaults=True):
    """Material that a machine needs and that cannot be fetched anywhere, so that no vehicle is hired."""

    item: Id
    quantity: Count
    short: tuple[Id, ...] = ()
    """Storages whose stations have too little."""
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
    """Pieces of `level` that are reserved for tasks; never more than `level`."""
    wanted: Count = 0
    """Pieces that are requested and cannot be reserved yet."""
    on_order: Count = 0
    """Pieces on their way here, or ordered."""
    uncounted: bool = False
    """Whether only a lower bound is known, which is `level`, until a person has counted."""


class UnconfirmedLoad(Part, frozen=True, omit_defaults=True):
    """A load that a vehicle has brought or taken by its own report, and that people have not confirmed yet."""

    vehicle: Id
    item: Id
    quantity: Count
    goes: bool = False
    """Whether it was taken away; otherwise it was brought."""


class DoubtfulLoad(Part, frozen=True, omit_defaults=True):
    """A load that may lie at a place although it is not in its stock: nobody can tell, so a person counts."""

    load: Id
    """Its name, for the person's answer (`MachineCommand.task`)."""
    vehicle: Id
    """The vehicle that was at the dock for it."""
    item: Id
    quantity: Count
    brought: bool = False
    """Whether the vehicle was to bring it; otherwise to take it."""


DOUBTS_TOLD = 8
"""Maximum doubtful loads in a heartbeat: more than a person looks for at once."""

LOADS_TOLD = 8
"""Maximum unconfirmed loads in a heartbeat: more than people confirm at one look."""


class GoalToCome(Part, frozen=True, omit_defaults=True):
    """Pieces of a goal that the gate admits, and whose arrival people have not reported yet."""

    goal: Id
    quantity: Count


GOALS_TOLD = 50
"""Maximum goals in a heartbeat of the gate: more than a person looks through. The codes on the labels identify others."""


class PeopleAsBody(Part, frozen=True, omit_defaults=True):
    """The state of an agent whose body is people, who report what happens."""

    loads: Annotated[tuple[UnconfirmedLoad, ...], Meta(max_length=LOADS_TOLD)] = ()
    """Unconfirmed loads, the oldest first."""
    goals: Annotated[tuple[GoalToCome, ...], Meta(max_length=GOALS_TOLD)] = ()
    """For the gate: goals with pieces to come, the quietest first."""


class StationHeartbeat(Message, said_by=STATIONS | GATES, signed="station", frozen=True, omit_defaults=True):
    """The public state of a storage's or source warehouse's agent, at 0.2 Hz and after changes: its stock and its promises."""

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
    """Vehicles whose answers a recovery poll of its tables still needs before it grants places; at most the first `AWAITED_MAX`."""
    dock_wait: DockWait | UnsetType = UNSET
    """Left out while its dock gets ready in time."""
    people: PeopleAsBody | UnsetType = UNSET
    """Left out when its body is not people."""
    doubts: Annotated[tuple[DoubtfulLoad, ...], Meta(max_length=DOUBTS_TOLD)] = ()
    """Loads for which a person is asked to count, the oldest first."""
    problem: Text = ""
    """For the gate: why it counts nothing or does not let a container in, in words; empty otherwise."""


class MachineHeartbeat(Message, said_by=MACHINES, signed="machine", frozen=True, omit_defaults=True):
    """MHB: the public state of a machine (paper, 3.2).

    At 0.2 Hz while idle, at 1 Hz while working or with a problem, and at once when the status changes. A goal stays in `goals` until
    the strategist has closed it, so that the strategist misses nothing.
    """

    machine: Id
    incarnation: Count
    seq: Count
    at_s: Seconds
    status: MachineStatus
    product: IdOrNone = ""
    """The product in work; empty for none."""
    goals: tuple[GoalBrief, ...] = ()
    """In the order in which they are worked at."""
    tasks: tuple[TaskBrief, ...] = ()
    buffers: tuple[BufferLevel, ...] | UnsetType = UNSET
    """In the order of the plant file. Unchanged buffers, goods and documents are left out (`dray.messages.heartbeat_stock`)."""
    goods: tuple[BufferLevel, ...] | UnsetType = UNSET
    """Finished products that wait to be carried away."""
    documents: Annotated[tuple[DocumentBrief, ...], Meta(max_length=DOCUMENTS_TOLD)] | UnsetType = UNSET
    waits: tuple[MaterialWait, ...] = ()
    """Needed material that cannot be fetched, the oldest first."""
    problem: Text = ""
    """What keeps it in ERROR, in words; empty otherwise."""
    about_problem: Problem | UnsetType = UNSET
    """Details of that problem; left out when there is none, or nothing is known."""
    resettable: bool | UnsetType = UNSET
    """Whether its sensors find nothing wrong any more, and it waits for a person's confirmation; left out otherwise."""
    help: HelpWanted | UnsetType = UNSET
    """Set while a person could still save its goals."""
    out_of_service: OutOfService | UnsetType = UNSET
    """Left out while it is in service."""
    speed_frac: Fraction | UnsetType = UNSET
    """A person's limit, as a fraction of its own speed; left out without one."""
    software: Text = ""
    draining: bool = False
    """Whether it was asked to shut down: it takes no new work, and stops when nothing holds it any more."""
    probation: ProbationBrief | None = None
    """Set while it is on probation: it takes short goals only."""
    joining: JoiningMachine | None = None
    """Set when the plant file did not contain it."""
    people: PeopleAsBody | UnsetType = UNSET
    """Left out when its body is not people."""
    doubts: Annotated[tuple[DoubtfulLoad, ...], Meta(max_length=DOUBTS_TOLD)] = ()
    """Loads for which a person is asked to count, the oldest first."""
    awaits: Awaited | UnsetType = UNSET
    """Vehicles whose answers a recovery poll of its tables still needs before it grants places; at most the first `AWAITED_MAX`."""
    dock_wait: DockWait | UnsetType = UNSET
    """Left out while its dock gets ready in time."""
