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
    OrderReleased,
    OutOfService,
    PartDefinition,
    Phase,
    ProductDefinition,
    Production,
    Reason,
    StrandedGoods,
    TakenOver,
    Transport,
)
from dray.messages.base import Part
from dray.messages.contract import Brought
from dray.messages.floor.traffic import AllRemoved, Bookings
from dray.messages.gate import GoalOf
from dray.messages.transport import TransportState


class AtvMemory(Part, tag_field="kind", tag="atv", frozen=True):
    """What a vehicle is bound by: the transport that it is primary of, if any.

    Watches are not remembered: a coordinator notices from the heartbeat that a watch is gone.
    """

    contract: Contract | None = None
    acknowledged: bool = False
    """A stop was acknowledged and not resumed yet; whether it is stopped is for the body to know."""
    stopped_itself: bool = False
    """It has stopped because another one used its name, and no person has seen to it yet."""
    speed_frac: float = 1.0
    out_of_service: OutOfService | None = None
    """By a person's word; None while it is in service."""
    sent_to_charge: bool = False
    """By a person's word: it takes no work before it is full."""
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
    put_away: tuple[PutAwayMemory, ...] = ()
    """Parts that it has asked storages to fetch."""
    put_away_count: int = 0
    """Names of those go on from here."""
    let_in: tuple[ReservationMemory, ...] = ()
    """Loads that others' vehicles may have taken, where the body does not count."""
    leaving: tuple[DepartureMemory, ...] = ()
    """Vehicles that may still be at its dock though they are not wanted there any more."""
    booked: tuple[DepartureMemory, ...] = ()
    """What its body was told that vehicles have moved, and has not answered yet."""


class ProductMemory(Part, frozen=True):
    """A product that a goal has brought, as its machine remembers it."""

    product: str
    definition: ProductDefinition


class PutAwayMemory(Part, frozen=True):
    """What a machine has asked a storage to have fetched."""

    transport: str
    storage: str
    part: str
    quantity: int
    due_s: float


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
    held: int = 1
    """With which epoch the order is held by the strategist that it obeys."""
    disputes: int = 0
    """Handovers of its pieces, one after the other, of which the gate has counted nothing."""
    by_people: bool = False
    """People count at the gate, later than goods come."""


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
    stranded: StrandedGoods | None = None
    """Its goods wait for a person's word, or to be fetched by another vehicle."""
    forgotten_aboard: bool = False
    """Its carrier has forgotten it, and had its thing on board then."""
    disputes: int = 0
    """Handovers of which nothing was counted, since a person has looked last."""
    held: bool = False
    """Nobody carries it before a person has looked whether its load is there."""


class StationMemory(Part, tag_field="kind", tag="station", frozen=True):
    """What the station of a storage is bound by. Who waits in its queue asks again."""

    reserved: tuple[ReservationMemory, ...] = ()
    tasks: tuple[TaskMemory, ...] = ()
    answered: tuple[CommandMemory, ...] = ()
    """People's words that it would obey if they came again."""
    let_in: tuple[ReservationMemory, ...] = ()
    """As a machine's."""
    leaving: tuple[DepartureMemory, ...] = ()
    """As a machine's."""
    booked: tuple[DepartureMemory, ...] = ()
    """As a machine's."""


class DepartureMemory(Part, frozen=True):
    """A vehicle that may be at a dock, and what it may have put down (`change` above 0) or taken there; 0 where nobody knows."""

    vehicle: str
    task: str = ""
    epoch: int = 0
    item: str = ""
    change: int = 0
    let_in: bool = True
    """Whether the dock was opened for it; before that it has put nothing down."""
    returns: bool = False
    """Whether it stands there to put back what it has on board."""


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
    vehicle_until_s: float | None = None
    """Until when only `vehicle` is asked; None for always."""
    ability: str = ""
    """What its vehicle must be able to carry beside what the load asks for."""


class StrategistMemory(Part, tag_field="kind", tag="strategist", frozen=True):
    """What the strategist is bound by beside its orders."""

    goal_count: int = 0
    """Names of goals go on from here."""


class EndedOrder(Part, tag_field="kind", tag="ended", frozen=True):
    """An order that has ended: no release of it is begun any more."""

    fulfilled: bool = False
    """All of it has arrived; else it was cancelled."""
    change: int = 0
    """The last one that was taken."""
    quantities: tuple[int, ...] = ()
    """Per item, all that has arrived; empty where it was cancelled."""


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
    change: int = 0
    """Of the order as it is now wanted."""
    wanted: tuple[int, ...] = ()
    """Per item, as many pieces as a change asks for that is not done yet; empty where none is under way."""
    parts: tuple[PartDefinition, ...] = ()
    """As the order has brought them."""


class OrderNoted(Part, tag_field="kind", tag="noted", frozen=True):
    """An order as it was said last, where a plant has several strategists: whoever holds it, each of them may have to go on with it."""

    release: OrderReleased
    asker: str
    """Who has said it."""
    holder: str = ""
    """As far as that is known."""
    epoch: int = 0
    """Of the holder."""


class ShutWord(Part, tag_field="kind", tag="shut_word", frozen=True):
    """What a strategist has to tell the gate and has no answer to: that a goal is shut, or an order has ended. Its orders do not tell that."""

    goal: str = ""
    order: str = ""
    epoch: int = 0
    """With which it holds the order."""
    over: int = 0
    """Releases of the order up to this one have ended."""


class GateMemory(Part, tag_field="kind", tag="gate", frozen=True):
    """What the gate of the delivery warehouses is bound by beside goals and orders."""

    since: int
    """The life in which its notes begin."""


class GateGoal(Part, tag_field="kind", tag="gate_goal", frozen=True):
    """A goal as the gate remembers it."""

    goal: str
    asker: str
    """The strategist whose word about it counts, and who is told what has arrived."""
    admitted: int
    incarnation: int
    number: int
    """Of the last word about it."""
    arrived: int = 0
    heard: int = 0
    """So many of these its strategist has heard of."""
    of: GoalOf | None = None
    brought: tuple[Brought, ...] = ()


class GateOrder(Part, tag_field="kind", tag="gate_order", frozen=True):
    """Who holds an order, as the gate remembers it."""

    order: str
    holder: str
    epoch: int
    over: int = 0
    arrived: tuple[int, ...] = ()
    """Per item, over all goals that it ever had."""
    lost_by: str = ""
    """Who has held it before and has not heard yet that it is lost."""


class GoalBooked(Part, frozen=True):
    """A goal of an order that is not delivered yet; `machine` is empty while nobody has taken it."""

    goal: str
    work: Production
    deadline_s: float
    machine: str = ""
    epoch: int = 1
    arrived: int = 0
    """Pieces that were counted at the gate, and told of; of a part, those that its machine has made."""


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
    | OrderNoted
    | ReturnedOrder
    | EndedOrder
    | BookMemory
    | ShutWord
    | GateMemory
    | GateGoal
    | GateOrder
)

CLOSURES = "closures"
"""The name of a vehicle's note about them: it changes seldom, and its contract often."""

WHOLE = ""
"""The name of an agent's only note, or of that which is about none of its orders. An order's note has its id."""

Memory = Mapping[str, Note]
"""Notes by name, in the order in which they were first written; one that is written again keeps its place."""

Changes = Mapping[str, Note | None]
"""What is to become of notes, by name: None for those that are not needed any more."""
