"""An agent's durable commitments, written for its next life.

A memory is a few notes, each small, frozen and with a name. They hold what others rely on and what the agent cannot
sense: contracts, epochs, counts. Everything else is sensed or asked anew. A vehicle and a machine have one note each.
The strategist has one per order, so that writes stay small with many open orders.
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
    ProblemKind,
    ProductDefinition,
    Production,
    Reason,
    StrandedGoods,
    TakenOver,
    Transport,
)
from dray.messages.base import Part
from dray.messages.contract import Brought
from dray.messages.floor.traffic import AllGivenBack, AllRemoved, PlaceReservations
from dray.messages.gate import GoalOf
from dray.messages.transport import TransportState


class ProblemMemory(Part, frozen=True):
    """The present problem of a vehicle or a machine: its next life waits no longer before it calls a person."""

    kind: ProblemKind
    since_s: float


class AtvMemory(Part, tag_field="kind", tag="atv", frozen=True):
    """A vehicle's commitments: the transport of which it is primary, if any.

    Watches are not remembered: a coordinator notices from the heartbeat that a watch is gone.
    """

    contract: Contract | None = None
    acknowledged: bool = False
    """A stop was acknowledged and not resumed yet; the body knows whether the vehicle is stopped."""
    stopped_itself: bool = False
    """It stopped without a command, and no person has seen to it yet."""
    stop_cause: str = ""
    """Why it stopped without a command, until it is resumed; empty if a person has stopped it."""
    speed_frac: float = 1.0
    out_of_service: OutOfService | None = None
    """Taken out of service by a person; None while it is in service."""
    sent_to_charge: bool = False
    """Sent to charge by a person: it takes no work before it is full."""
    answered: tuple[CommandMemory, ...] = ()
    """Answered commands that must not be executed again, the oldest first: those whose grant was still valid when the last
    one came."""
    problem: ProblemMemory | None = None
    node: str = ""
    """The last node that it had passed then, for people who look for it; empty where it is not known."""
    put_down: tuple[Contract, ...] = ()
    """Ended transports whose coordinators have not confirmed that the load is down."""
    forgot_at: str = ""
    """The node where it has lost its memory; empty for none, and once that tells nobody anything any more."""
    left_empty: bool = False
    """Whether it has left that node with nothing on board."""


class ClosuresMemory(Part, tag_field="kind", tag="closures", frozen=True):
    """The closures that a vehicle obeys: its next life knows them before it hears anybody."""

    list: Closures


class CommandMemory(Part, frozen=True):
    """The outcome of a command, as the vehicle or machine remembers it."""

    command: str
    person: str
    """The person on whose behalf it was given; another person's command may have the same name."""
    valid_until_s: float
    refused: CommandRefusal | None = None
    """The reason for refusal; None when it was obeyed."""
    detail: str = ""
    """The sensors' report, where that was the reason."""


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
    """The reason why it ends as soon as the load is off; None while it holds."""
    number: int = 0
    """The number of the award that gave it; 0 for a takeover."""
    claim: TakenOver | None = None
    """The takeover message that its coordinator has not confirmed yet."""
    refused: int = 0
    """Number of times that the gate of the delivery warehouses refused the load."""


class MachineMemory(Part, tag_field="kind", tag="machine", rename={"visits": "leaving"}, frozen=True):
    """A machine's commitments."""

    goals: tuple[GoalMemory, ...] = ()
    tasks: tuple[TaskMemory, ...] = ()
    task_count: int = 0
    """Tasks named so far; names continue from here."""
    help: HelpWanted | None = None
    """The help its goals wait for, and for how long."""
    out_of_service: OutOfService | None = None
    speed_frac: float = 1.0
    answered: tuple[CommandMemory, ...] = ()
    """Answered commands, which it must not obey again."""
    products: tuple[ProductMemory, ...] = ()
    """Products of pieces in its goods for which it was not set up."""
    put_away: tuple[PutAwayMemory, ...] = ()
    """Parts that it has asked storages to fetch."""
    put_away_count: int = 0
    """Put-away requests named so far; names continue from here."""
    let_in: tuple[ReservationMemory, ...] = ()
    """Loads that other coordinators' vehicles may have taken, in notes of older versions (`visits_of`)."""
    visits: tuple[DepartureMemory, ...] = ()
    """Vehicles at its dock whose loads are not decided yet."""
    booked: tuple[DepartureMemory, ...] = ()
    """Transfers of vehicles that were sent to the body for booking and not answered yet."""
    problem: ProblemMemory | None = None
    doubts: tuple[DoubtMemory, ...] = ()
    """Loads of which nobody can tell whether they lie there."""


class ProductMemory(Part, frozen=True):
    """A product defined by a goal, as its machine remembers it."""

    product: str
    definition: ProductDefinition


class PutAwayMemory(Part, frozen=True):
    """A machine's request to a storage to fetch a part."""

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
    """Pieces that were made and then lost on the way."""
    epoch: int = 1
    number: int = 1
    """The number of the award that gave it."""
    confirmed: bool = True
    """Whether its strategist has confirmed the machine's acceptance."""
    held: int = 1
    """The epoch with which the machine's strategist holds the order."""
    taken_over: bool = False
    """Whether a strategist has said that it has taken the order over."""
    disputes: int = 0
    """Consecutive handovers of its pieces of which the gate has counted nothing."""
    by_people: bool = False
    """Whether people count at the gate, later than goods arrive."""
    promised_s: float = 0.0
    """The promised finish that holds now; 0 where an older version made the note."""
    came_before: int = 0
    """More urgent goals that have come before it since it was taken."""


class TaskMemory(Part, rename={"forgotten_aboard": "left_aboard"}, frozen=True):
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
    """The goods have left this machine."""
    secondary: str = ""
    watch_number: int = 0
    """The number of the award by which the secondary watches."""
    offered: bool = True
    """Whether it was announced in this epoch."""
    recovered: bool = False
    """Restored from its carrier's message alone, after a life that left no notes."""
    least_epoch: int = 0
    """The lowest valid epoch, as a carrier was told; 0 where none was told."""
    stranded: StrandedGoods | None = None
    """Its goods wait for a person's word, or for another vehicle."""
    forgotten_aboard: bool = False
    """Its carrier has forgotten it while its thing was on board."""
    disputes: int = 0
    """Handovers of which nothing was counted, since the last inspection by a person."""
    held: bool = False
    """It waits until a person has checked whether its load is there."""
    perhaps_down: DepartureMemory | None = None
    """While it is held: the load that its last carrier may have put down, and that nobody else can tell of."""
    fails_at: str = ""
    """While it is held: the place where carriers could not load or unload it."""


class StationMemory(Part, tag_field="kind", tag="station", rename={"visits": "leaving"}, frozen=True):
    """A storage station's commitments. Its queue is not kept, because waiting vehicles ask again."""

    reserved: tuple[ReservationMemory, ...] = ()
    tasks: tuple[TaskMemory, ...] = ()
    answered: tuple[CommandMemory, ...] = ()
    """Answered commands, which it must not obey again."""
    let_in: tuple[ReservationMemory, ...] = ()
    """As a machine's."""
    visits: tuple[DepartureMemory, ...] = ()
    """As a machine's."""
    booked: tuple[DepartureMemory, ...] = ()
    """As a machine's."""
    doubts: tuple[DoubtMemory, ...] = ()
    """As a machine's."""


class DepartureMemory(Part, frozen=True):
    """A vehicle that may be at a dock, and the load that it may have moved."""

    vehicle: str
    task: str = ""
    epoch: int = 0
    item: str = ""
    change: int = 0
    """Pieces that the place has more then: positive for a load to bring, negative for one to take, 0 for unknown."""
    let_in: bool = True
    """Whether the dock was opened for it; before that it cannot have put anything down."""
    returns: bool = False
    """Whether it waits there to put its load back."""
    gone: bool = False
    """Whether it has left, and only its own report can tell that the load lies there, or its coordinator that it was fetched."""
    permitted: bool = False
    """Whether the permission for which the dock was opened stands."""
    coordinator: str = ""
    """Of a load that it may take for another place; empty where none is known."""
    ended: bool = False
    """Whether it named the task no more before the dock was opened for it."""

    @property
    def brings(self) -> bool:
        """Whether it is a load to bring."""
        return self.change > 0

    @property
    def takes(self) -> bool:
        """Whether it is a load to take."""
        return self.change < 0

    @property
    def quantity(self) -> int:
        """Pieces of the load."""
        return abs(self.change)

    @property
    def only_waits(self) -> bool:
        """Whether it waits for the dock to open, and may have moved nothing."""
        return not (self.let_in or self.change or self.returns)


class DoubtMemory(Part, frozen=True):
    """A load of which nobody can tell whether it lies at a place."""

    name: str
    load: DepartureMemory
    asked: bool = False
    """Whether a person is asked."""


class ReservationMemory(Part, frozen=True):
    """Pieces that are set aside, as the station remembers them."""

    task: str
    epoch: int
    item: str
    quantity: int
    coordinator: str
    vehicle: str = ""
    """The vehicle for which the dock was opened; empty before."""
    opened: int = 0
    """The epoch of the task in which it was opened; 0 before."""
    ended: bool = False
    """See `DepartureMemory`; in notes of older versions."""
    gone: bool = False
    """See `DepartureMemory`; in notes of older versions."""


def visits_of(note: MachineMemory | StationMemory) -> tuple[DepartureMemory, ...]:
    """The visits at a dock in a note. An older version noted loads to take apart, beside the vehicles whose permission had ended."""
    ended = {each.vehicle for each in note.visits if not each.gone}
    taken = tuple(
        DepartureMemory(
            each.vehicle,
            each.task,
            each.opened,
            each.item,
            -each.quantity,
            gone=each.gone,
            permitted=each.vehicle not in ended,
            coordinator=each.coordinator,
            ended=each.ended,
        )
        for each in note.let_in
    )
    known = {each.vehicle for each in taken}
    return (*taken, *(each for each in note.visits if each.gone or each.vehicle not in known))


class TransportMemory(Part, tag_field="kind", tag="transport_called", frozen=True):
    """A plain transport as its destination remembers it, and for a while after its end."""

    transport: str
    source: str
    item: str
    quantity: int
    due_s: float
    vehicle: str
    state: TransportState
    done: int = 0
    """Pieces delivered."""
    attempt: int = 0
    """Number of task names under which it was announced."""
    vehicle_until_s: float | None = None
    """Plant time until which only `vehicle` is asked; None for always."""
    ability: str = ""
    """An ability that its vehicle needs beside those for the load."""


class StrategistMemory(Part, tag_field="kind", tag="strategist", frozen=True):
    """The strategist's commitments beside its orders."""

    goal_count: int = 0
    """Goals named so far; names continue from here."""


class EndedOrder(Part, tag_field="kind", tag="ended", frozen=True):
    """An order that has ended: none of its releases is started again."""

    fulfilled: bool = False
    """Whether all of it has arrived; otherwise it was cancelled."""
    change: int = 0
    """The number of the last accepted change."""
    quantities: tuple[int, ...] = ()
    """Per item, all that has arrived; empty where it was cancelled."""


class ReturnedOrder(Part, tag_field="kind", tag="returned", frozen=True):
    """An order that was taken back: only a later release of it is accepted."""

    order: str
    release: int
    outstanding: tuple[int, ...] = ()
    """Per item, pieces that had not arrived; empty when this release never came."""


class OrderMemory(Part, tag_field="kind", tag="order", frozen=True):
    """An order in work as the strategist remembers it."""

    order: str
    items: tuple[OrderItem, ...]
    due_s: float
    goals: tuple[GoalBooked, ...]
    release: int = 1
    revoked_by: str = ""
    """The agent that takes it back and waits for its end; empty while it is worked at."""
    withdrawn: tuple[int, ...] = ()
    """Per item, pieces of goals that were withdrawn and had not arrived."""
    change: int = 0
    """The number of the last change of the order."""
    wanted: tuple[int, ...] = ()
    """Per item, pieces asked for by a change in progress; empty where none is."""
    parts: tuple[PartDefinition, ...] = ()
    """Part definitions that came with the order."""


class OrderNoted(Part, tag_field="kind", tag="noted", frozen=True):
    """The latest version of an order, noted by every strategist of a plant with several: each may have to take it over."""

    release: OrderReleased
    asker: str
    """The agent that sent it."""
    holder: str = ""
    """The strategist that holds it, if known."""
    epoch: int = 0
    """The holder's epoch."""


class ShutWord(Part, tag_field="kind", tag="shut_word", frozen=True):
    """A strategist's unanswered message to the gate: a goal is shut, or an order has ended. Its order notes do not contain it."""

    goal: str = ""
    order: str = ""
    epoch: int = 0
    """The epoch with which it holds the order."""
    over: int = 0
    """Releases of the order up to this one have ended."""


class GateMemory(Part, tag_field="kind", tag="gate", frozen=True):
    """The gate's commitments beside goals and orders."""

    since: int
    """The life in which its notes began."""


class GateGoal(Part, tag_field="kind", tag="gate_goal", frozen=True):
    """A goal as the gate remembers it."""

    goal: str
    asker: str
    """The strategist that may change the goal, and that is told about arrivals."""
    admitted: int
    incarnation: int
    number: int
    """The number of the last message about it."""
    arrived: int = 0
    heard: int = 0
    """Arrived pieces that its strategist has confirmed."""
    of: GoalOf | None = None
    brought: tuple[Brought, ...] = ()


class GateOrder(Part, tag_field="kind", tag="gate_order", frozen=True):
    """The holder of an order, as the gate remembers it."""

    order: str
    holder: str
    epoch: int
    over: int = 0
    arrived: tuple[int, ...] = ()
    """Pieces arrived per item, over all goals of the order."""
    lost_by: str = ""
    """The previous holder, until it has heard of its loss."""


class GoalBooked(Part, frozen=True):
    """A goal of an undelivered order; `machine` is empty while no machine has taken it."""

    goal: str
    work: Production
    deadline_s: float
    machine: str = ""
    epoch: int = 1
    arrived: int = 0
    """Pieces counted at the gate and reported; for a part, those that its machine has made."""


class TableMemory(Part, tag_field="kind", tag="book", rename={"reservations": "bookings"}, frozen=True):
    """A copy of a district's table, as its replica remembers it (`dray.protocol.traffic.reservations.copies`)."""

    epoch: int
    """The highest epoch that the replica has promised or heard of."""
    kept_epoch: int
    """The epoch of the leader that wrote this copy."""
    version: int
    reservations: PlaceReservations = ()
    removed: AllRemoved = ()
    given_back: AllGivenBack = ()
    """As leader: the vehicles' words by which it has struck out lines, and which another replica may still need."""


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
    | TableMemory
    | ShutWord
    | GateMemory
    | GateGoal
    | GateOrder
)

CLOSURES = "closures"
"""The name of a vehicle's note about closures, kept apart from its contract because it changes seldom."""

WHOLE = ""
"""The name of an agent's only note, or of the one about no order. An order's note has its id."""

Memory = Mapping[str, Note]
"""Notes by name, in the order in which they were first written; a rewritten note keeps its place."""

Changes = Mapping[str, Note | None]
"""Changed notes by name; None for a note to delete."""
