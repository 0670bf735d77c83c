"""What agents are bound by, as it is written down for their next life.

A memory is a few notes, each small, frozen and with a name. They hold what others rely on and what the agent's
senses cannot tell it: contracts, epochs, counts. Everything else is sensed or asked anew. A vehicle and a machine
have one note; the strategist has one per order, so that what it writes in a step does not grow with all that it
has in work.
"""

from __future__ import annotations

from collections.abc import Mapping

from dray.messages import (
    Closures,
    CommandRefusal,
    HelpWanted,
    OrderItem,
    OutOfService,
    Phase,
    ProductDefinition,
    Production,
    Reason,
    TakenOver,
    Transport,
)
from dray.messages.base import Part
from dray.messages.floor.traffic import AllRemoved, Bookings
from dray.messages.transport import TransportState


class AtvMemory(Part, tag_field="kind", tag="atv", frozen=True):
    """What a vehicle is bound by: the transport that it is primary of, if any.

    Watches are not remembered: a coordinator notices from the heartbeat that a watch is gone.
    """

    contract: Contract | None = None
    acknowledged: bool = False
    """A stop was acknowledged and not resumed yet; whether it is stopped is for the body to know."""
    speed_frac: float = 1.0
    out_of_service: OutOfService | None = None
    """By a person's word; None while it is in service."""
    answered: tuple[CommandMemory, ...] = ()
    """People's commands that are not obeyed again, the oldest first: those whose grant was still good when
    the last one came."""


class ClosuresMemory(Part, tag_field="kind", tag="closures", frozen=True):
    """The closures that a vehicle goes by: its next life knows them before it hears anybody."""

    list: Closures


class CommandMemory(Part, frozen=True):
    """What became of a command, as the vehicle or machine remembers it."""

    command: str
    person: str
    """On whose behalf it was given; another's command may have the same name."""
    valid_until_s: float
    refused: CommandRefusal | None = None
    """Why; None when it was obeyed."""
    detail: str = ""
    """What its sensors reported, where that was why."""


class Contract(Part, frozen=True):
    """A transport as its primary remembers it."""

    task: str
    epoch: int
    work: Transport
    coordinator: str
    source: str
    promised_s: float
    deadline_s: float
    phase: Phase = Phase.APPROACHING
    cancelled: Reason | None = None
    """Why it is to end as soon as the load is off; None while it holds."""
    number: int = 0
    """Of the award by which it was given; 0 for a takeover."""
    claim: TakenOver | None = None
    """What is said of a takeover that its coordinator has not confirmed yet."""
    refused: int = 0
    """How often the gate of the delivery warehouses has not let the load in."""


class MachineMemory(Part, tag_field="kind", tag="machine", frozen=True):
    """What a machine is bound by."""

    goals: tuple[GoalMemory, ...] = ()
    tasks: tuple[TaskMemory, ...] = ()
    task_count: int = 0
    """Names of tasks go on from here."""
    help: HelpWanted | None = None
    """How long its goals wait for a person."""
    out_of_service: OutOfService | None = None
    speed_frac: float = 1.0
    answered: tuple[CommandMemory, ...] = ()
    """Commands that it would obey if they came again."""
    products: tuple[ProductMemory, ...] = ()
    """Of which pieces lie in its goods, though it was not set up for them."""


class ProductMemory(Part, frozen=True):
    """A product that a goal has brought, as its machine remembers it."""

    product: str
    definition: ProductDefinition


class GoalMemory(Part, frozen=True):
    """A goal as its machine remembers it."""

    goal: str
    work: Production
    strategist: str
    deadline_s: float
    made: int
    delivered: int
    lost_in_transit: int
    """Pieces that were made and lost on the way."""
    epoch: int = 1
    number: int = 1
    """Of the award by which it was given."""
    confirmed: bool = True
    """Whether its strategist has heard that it was taken."""


class TaskMemory(Part, frozen=True):
    """An open transport as its coordinator remembers it."""

    task: str
    epoch: int
    work: Transport
    deadline_s: float
    opened_s: float
    primary: str = ""
    source: str = ""
    promised_s: float = 0.0
    loaded: bool = False
    """Goods that have left this machine."""
    secondary: str = ""
    watch_number: int = 0
    """Of the award by which the secondary watches."""
    offered: bool = True
    """Whether anybody was asked to carry it in this epoch."""
    recovered: bool = False
    """Taken up on its carrier's word alone, after a life that has left no notes."""
    least_epoch: int = 0
    """A carrier was told that no epoch below this one is right any more; 0 where none was."""


class StationMemory(Part, tag_field="kind", tag="station", frozen=True):
    """What the station of a storage is bound by. Who waits in its queue asks again."""

    reserved: tuple[ReservationMemory, ...] = ()
    tasks: tuple[TaskMemory, ...] = ()


class ReservationMemory(Part, frozen=True):
    """Pieces that are set aside, as the station remembers them."""

    task: str
    epoch: int
    item: str
    quantity: int
    coordinator: str
    vehicle: str = ""
    """For whom the dock was opened; empty before."""
    opened: int = 0
    """In which epoch of the task; 0 before."""


class TransportMemory(Part, tag_field="kind", tag="transport_called", frozen=True):
    """A plain transport as the place remembers it to which it goes; also for a while when it has ended."""

    transport: str
    source: str
    item: str
    quantity: int
    due_s: float
    vehicle: str
    state: TransportState
    done: int = 0
    """Pieces that were brought."""
    attempt: int = 0
    """How often it was given out under a name of its own."""


class StrategistMemory(Part, tag_field="kind", tag="strategist", frozen=True):
    """What the strategist is bound by beside its orders."""

    goal_count: int = 0
    """Names of goals go on from here."""


class EndedOrder(Part, tag_field="kind", tag="ended", frozen=True):
    """An order that has ended: no release of it is begun any more."""

    fulfilled: bool = False
    """All of it has arrived; else it was cancelled."""


class ReturnedOrder(Part, tag_field="kind", tag="returned", frozen=True):
    """An order that was taken back: a later release of it is taken, and no other."""

    order: str
    release: int
    outstanding: tuple[int, ...] = ()
    """Per item, what had not arrived; empty when this release never came."""


class OrderMemory(Part, tag_field="kind", tag="order", frozen=True):
    """An order in work as the strategist remembers it."""

    order: str
    items: tuple[OrderItem, ...]
    due_s: float
    goals: tuple[GoalBooked, ...]
    release: int = 1
    revoked_by: str = ""
    """Who has taken it back and waits for its end; empty while it is worked at."""
    withdrawn: tuple[int, ...] = ()
    """Per item, pieces of goals that were withdrawn and had not arrived."""


class GoalBooked(Part, frozen=True):
    """A goal of an order that is not delivered yet; `machine` is empty while nobody has taken it."""

    goal: str
    work: Production
    deadline_s: float
    machine: str = ""
    epoch: int = 1
    arrived: int = 0
    """Pieces that were counted at the gate, and told of."""


class BookMemory(Part, tag_field="kind", tag="book", frozen=True):
    """The book of a district as one of its keepers remembers it (`dray.protocol.traffic.books.copies`)."""

    epoch: int
    """The highest that it has promised, or heard of."""
    kept_epoch: int
    """Of the one who has written the copy."""
    version: int
    bookings: Bookings = ()
    removed: AllRemoved = ()


Note = (
    AtvMemory
    | ClosuresMemory
    | MachineMemory
    | StationMemory
    | TransportMemory
    | StrategistMemory
    | OrderMemory
    | ReturnedOrder
    | EndedOrder
    | BookMemory
)

CLOSURES = "closures"
"""The name of a vehicle's note about them: it changes seldom, and its contract often."""

WHOLE = ""
"""The name of an agent's only note, or of that which is about none of its orders. An order's note has its id."""

Memory = Mapping[str, Note]
"""Notes by name, in the order in which they were first written; one that is written again keeps its place."""

Changes = Mapping[str, Note | None]
"""What is to become of notes, by name: None for those that are not needed any more."""
