"""What an agent and its body say to one another: instructions down, reports up.

An agent decides, a body acts. A vehicle's body may be simulated or a real vehicle behind VDA 5050:
a way is given as nodes of which a first part is released (VDA 5050's base and horizon), picking and
dropping are actions at a node, holding and going on work at once, and every step comes back as a
report. A machine's body is its workcell: cycles, buffers and the dock. An operator's is a person with a tablet.

Every way and action has an `order` number that its agent chose; reports carry it back, so that a
report about something that was replaced meanwhile is recognised and ignored.
"""

from __future__ import annotations

from enum import StrEnum
from typing import TypeVar

import msgspec

from dray.document import DocumentRead as DocumentRead  # noqa: PLC0414 - told from here, too
from dray.document import ReadDocument as ReadDocument  # noqa: PLC0414
from dray.gate import Admit as Admit  # noqa: PLC0414 - told from here, too
from dray.gate import GateState as GateState  # noqa: PLC0414
from dray.gate import GoodsArrived as GoodsArrived  # noqa: PLC0414
from dray.gate import HoldOrder as HoldOrder  # noqa: PLC0414
from dray.messages.base import (
    COUNT_MAX,
    HEADING_MAX_RAD,
    LONGEST_S,
    METRES_MAX,
    SPEED_MAX_MPS,
    Part,
    encodable,
)
from dray.messages.floor.obstacle import WayBlocked as WayBlocked  # noqa: PLC0414
from dray.messages.floor.obstacle import WayFree as WayFree  # noqa: PLC0414
from dray.messages.gate import OrderHeld
from dray.messages.heartbeat import BodyWait, Pose, UnconfirmedLoad
from dray.messages.link import Link
from dray.messages.people.call import CallAnswer, HelpCall
from dray.messages.people.command import MachineCommandKind
from dray.messages.problem import NOTHING_KNOWN, Problem, ProblemKind
from dray.messages.product import BillLine
from dray.messages.reason import CommandRefusal

# --- a vehicle: instructions ---------------------------------------------------------------------


class Drive(Part, frozen=True):
    """Follow a way. Replaces the way before it; ends charging.

    A moving vehicle finishes the lane that it is on and turns off there: `nodes[0]` must be the
    `VehicleState.next_node` of this moment. A standing vehicle stands at `nodes[0]`.
    """

    order: int
    nodes: tuple[str, ...]
    """At least one; each joined to the next by a lane."""
    released: int
    """How many of `nodes` may be driven to by now, from 1 to all: the vehicle brakes at the last one."""
    limits_mps: tuple[float | None, ...] = ()
    """The highest speed on each lane of the way, where people have made it slow; None where the plant's holds, and empty where
    it does everywhere."""


class ReleaseWay(Part, frozen=True):
    """More of the way may be driven."""

    order: int
    released: int


class Pick(Part, frozen=True):
    """Take a load up at the station where the vehicle stands; at a node that is no station, from a person's hands."""

    order: int
    station: str
    item: str
    quantity: int


class Drop(Part, frozen=True):
    """Put the load down at the station where the vehicle stands."""

    order: int
    station: str
    goal: str = ""
    """At a delivery warehouse, the goal whose pieces these are; without one they are set aside there."""


class Charge(Part, frozen=True):
    """Charge at the charger where the vehicle stands, until the next instruction or full."""

    order: int
    charger: str


class Hold(Part, frozen=True):
    """Stop at once and stay; actions pause too. Holding twice is harmless."""


class Unhold(Part, frozen=True):
    """Go on with what was held."""


SLOWEST_FRAC = 0.01
"""No limit is lower: a vehicle that is to stand is stopped."""


class LimitSpeed(Part, frozen=True):
    """Keep below this part of the vehicle's own top speed."""

    speed_frac: float
    """Above 0, at most 1; below SLOWEST_FRAC the vehicle keeps that."""


VehicleInstruction = Drive | ReleaseWay | Pick | Drop | Charge | Hold | Unhold | LimitSpeed

# --- a vehicle: reports and state ----------------------------------------------------------------


class NodePassed(Part, frozen=True):
    """A node of the way was reached, the first and last ones included."""

    order: int
    node: str
    index: int
    """Its place in `Drive.nodes`."""
    battery_frac: float


class WayDone(Part, frozen=True):
    """The vehicle stands at the last node of its way."""

    order: int
    node: str


class ActionDone(Part, frozen=True):
    """A pick or drop has ended well, or a charge has filled the battery."""

    order: int


class ActionFailed(Part, frozen=True):
    """A pick, drop or charge ended without effect: the load is where it was."""

    order: int
    reason: str


class ProblemRaised(Part, frozen=True):
    """Something keeps the vehicle from going on. Another one on top of it replaces it; the worst should be said last.

    How long its task waits follows from `problem` (`dray.protocol.people.patience`): say what is known, and no more.
    """

    reason: str
    """In words, for people; not empty."""
    problem: Problem = NOTHING_KNOWN
    """Its kind, and what is known of it."""


class ProblemCleared(Part, frozen=True):
    """It is gone."""


class LinkNoticed(Part, frozen=True):
    """The vehicle's modem has lost the WLAN, or is back on it."""

    link: Link
    access_point: str = ""
    """Of a loss: over which it was on the WLAN last; empty where the modem does not know."""


_OnTheWay = NodePassed | WayDone | WayBlocked | WayFree
VehicleReport = _OnTheWay | ActionDone | ActionFailed | ProblemRaised | ProblemCleared | LinkNoticed


class VehicleState(Part, frozen=True):
    """Everything a vehicle can sense of itself at one moment."""

    pose: Pose
    node: str
    """The last node that was passed."""
    next_node: str
    """Where a new way may begin: the end of the lane it is on, or `node` when it stands there."""
    next_node_s: float
    """Seconds until `next_node` at the present speed; 0 when it stands there."""
    speed_mps: float
    battery_frac: float
    load: str
    """Empty for nothing."""
    load_quantity: int
    held: bool
    charging: bool
    link: Link = Link.WLAN
    problem: str = ""
    """What keeps it from going on; empty for nothing."""
    about_problem: Problem = NOTHING_KNOWN
    """Its kind, and what is known of it; says nothing where there is none."""
    battery_reckoned: bool = False
    """It is not known how full it is: `battery_frac` is reckoned by time and metres."""
    wait: BodyWait | None = None
    """What it waits for at this moment; None for nothing, and where it does not tell."""
    base_end: str = ""
    """The node up to which the way that it was given last is released; empty when it has come there, or has none."""


# --- a workcell: instructions and reports --------------------------------------------------------


class StartCycle(Part, frozen=True):
    """Make one piece: takes the bill of material out of the buffers, puts a piece into the goods."""

    product: str
    bill: tuple[BillLine, ...] = ()
    """What it takes; empty for what the workcell was set up with."""
    cycle_s: float = 0.0
    """How long a piece takes at full speed, for a product that the workcell was not set up for; 0 where nobody says it."""


class OpenDock(Part, frozen=True):
    """Let this vehicle load or unload, once. The dock stays shut for everybody else."""

    vehicle: str
    item: str
    quantity: int


class DockReady(Part, frozen=True):
    """Whoever opens the dock has done so for this vehicle: it may load or unload now. Said by a body that `answers`."""

    vehicle: str


class CloseDock(Part, frozen=True):
    """Shut the dock again for this vehicle; harmless when it was never open. Said again, it has left, and nothing more is told of its load."""

    vehicle: str


class Book(Part, frozen=True):
    """A vehicle says that it has put pieces down or taken them: the only word there is for a body that does not count.

    Answered with `StockChanged`, as if it had been seen. Said again, by this life of its agent or the next, it is answered as before, and books nothing.
    """

    vehicle: str
    item: str
    change: int
    """Pieces; negative when something was taken."""
    task: str
    """The transport by which."""
    epoch: int
    """Of the transport."""


class ResetFault(Part, frozen=True):
    """A person says that the fault is gone: work again, if the sensors find nothing wrong."""


class SetPace(Part, frozen=True):
    """Work at a part of the own speed, from the next cycle on."""

    speed_frac: float
    """Above 0, and at most 1."""


class Word(Part, frozen=True):
    """What a person says has happened; only for a body that is people. It is answered with `WordTaken`, each time that it is said."""

    key: str
    """Names the word for ever: one that is said again under its key is not counted again."""
    kind: MachineCommandKind
    """One of `WORDS`."""
    item: str
    """Empty for the product that is being made."""
    quantity: int
    vehicle: str = ""
    sure: bool = False
    """The number is right, however far it is from the expected one."""


WorkcellInstruction = StartCycle | OpenDock | CloseDock | Book | ResetFault | SetPace | ReadDocument | Word


class CycleDone(Part, frozen=True):
    """A piece was made and lies in the goods, or was bad and is gone."""

    product: str
    seq: int
    """Of this change of the stock, of nothing for a bad piece; see `WorkcellState.seq`."""
    bad: bool = False
    """The piece is no good: it lies nowhere, and what the cycle has taken is used up."""


class CycleFailed(Part, frozen=True):
    """A cycle could not start; nothing was consumed."""

    product: str
    reason: str


class StockChanged(Part, frozen=True):
    """A vehicle or a person has put something in or taken something out."""

    item: str
    change: int
    """Pieces; negative when something was taken."""
    seq: int
    """Of this change of the stock; see `WorkcellState.seq`."""
    vehicle: str = ""
    counted: bool = False
    """A person has counted what lies there: nothing came or went."""


class Broken(Part, frozen=True):
    """The machine has stopped; a running cycle pauses. Said again when more is known."""

    reason: str
    problem: Problem = NOTHING_KNOWN
    """Its kind, and what is known of it: say what is known, and no more."""
    resettable: bool = False
    """The sensors find nothing wrong any more; it stands until `ResetFault`."""


class Repaired(Part, frozen=True):
    """The machine works again; a paused cycle goes on."""


class WordTaken(Part, frozen=True):
    """What became of a `Word`. One that was not refused is on the disk."""

    key: str
    refused: CommandRefusal | None = None
    detail: str = ""
    """The number that was expected, where that is why."""
    again: bool = False
    """It was said before."""


WorkcellReport = (
    CycleDone | CycleFailed | StockChanged | DockReady | Broken | Repaired | DocumentRead | WordTaken
)


class WorkcellState(Part, frozen=True):
    """What a workcell senses of itself.

    A state may be sensed before reports that explain it are heard, or told after them. So the changes of the stock
    that are reported have numbers: whoever has heard another last one than `seq` knows that this stock is of another
    moment.
    """

    stock: dict[str, int]
    """Pieces at hand of every material and product, those in a running cycle not counted."""
    seq: int
    """How many changes of the stock the workcell has reported since it was built; all of them are in `stock`."""
    cycling: str
    """The product of the running cycle; empty for none."""
    broken: str
    """Why it stands; empty when it works."""
    counts: bool = True
    """Whether it counts what vehicles bring and take. One that does not tells of no transfer by itself: its agent
    lets it `Book` what vehicles say, and its stock is as good as their word."""
    about_problem: Problem = NOTHING_KNOWN
    """What is known of why it stands; says nothing where it works."""
    resettable: bool = False
    """It stands, and waits for `ResetFault` only."""
    paces: bool = False
    """Whether it can work at a part of its speed."""
    answers: bool = False
    """Whether its dock takes time to open: `OpenDock` is answered with `DockReady`, once for each time that it is said."""
    people: bool = False
    """Whether it is people, whose words (`Word`) it takes."""
    loads: tuple[UnconfirmedLoad, ...] = ()
    """Of people: what vehicles have brought and taken by their own word, and nobody has confirmed yet; the oldest first."""
    opened: tuple[str, ...] = ()
    """Vehicles for which its dock is open, or is being opened, where it remembers them over its agent's lives."""
    gone: tuple[str, ...] = ()
    """Of people: vehicles that are not wanted there any more, and whose own word of their loads is still awaited."""


# --- a storage: instructions and state; it has a dock as a workcell has -------


class Refill(Part, frozen=True):
    """More of a material is needed than lies there: have some brought. Harmless when it is on its way already."""

    item: str


class StorageState(Part, frozen=True):
    """What a storage senses of itself."""

    stock: dict[str, int]
    """Pieces of every material."""
    seq: int
    """How many changes of the stock it has reported since it was built; see `WorkcellState`."""
    opened: tuple[str, ...]
    """Vehicles for which the dock is open, or is being opened: they have not taken yet what they may take."""
    answers: bool = False
    """Whether its dock takes time to open; see `WorkcellState`."""
    counts: bool = True
    """Whether it counts what vehicles bring and take; see `WorkcellState`."""
    uncounted: tuple[str, ...] = ()
    """Materials of which nobody knows how many pieces lie there, until somebody has counted: `stock` says what has come since, at least."""
    people: bool = False
    """Whether it is people, whose words (`Word`) it takes."""
    loads: tuple[UnconfirmedLoad, ...] = ()
    """Of people; see `WorkcellState`."""
    gone: tuple[str, ...] = ()
    """Of people; see `WorkcellState`."""


StorageInstruction = OpenDock | CloseDock | Book | Refill | Word

# --- a person with a tablet: the operator's body ---------------------------------------------------


class DutyState(Part, frozen=True):
    """What a tablet knows of the person who is on duty at it."""

    there: bool = True
    """The tablet is connected; an operator whose tablet is not leaves after a while."""
    on_break: bool = False
    busy_until_s: float | None = None
    """Busy by the person's own word until then (plant clock); None for not."""
    areas: tuple[str, ...] = ()
    everywhere: bool = False
    station: str = ""
    helps_with: tuple[ProblemKind, ...] = ()
    """Empty for everything."""
    label: str = ""
    """What others are shown of the person; empty where names are not told."""


class DutyChanged(Part, frozen=True):
    """The person or the tablet is otherwise than before."""

    state: DutyState


class CallReplied(Part, frozen=True):
    """The person answers a call, promises anew, or gives it back."""

    call: str
    answer: CallAnswer
    wait_s: float | None = None


class CallPart(StrEnum):
    """What the operator has to do with a call."""

    ASKED = "asked"
    TAKING = "taking"
    """Taken; the caller has not confirmed it yet."""
    TAKEN = "taken"
    """Confirmed: this operator is expected."""


class ShownCall(Part, frozen=True):
    """A call that concerns this operator."""

    call: HelpCall
    part: CallPart


class ShowCalls(Part, frozen=True):
    """All calls that concern this operator at this moment; what was shown before and is not here is over."""

    calls: tuple[ShownCall, ...]


OperatorReport = DutyChanged | CallReplied

Instruction = VehicleInstruction | WorkcellInstruction | StorageInstruction | Admit | HoldOrder | ShowCalls
Report = VehicleReport | WorkcellReport | GoodsArrived | OrderHeld | OperatorReport
BodyState = VehicleState | WorkcellState | StorageState | GateState | DutyState

Said = TypeVar("Said", bound=Report | BodyState)

# --- what a body may say ----------------------------------------------------------------------------

WORDS_MAX = 500
"""Characters of a body's own words: half of what a message may carry, since its agent says more around them."""


def bounded(said: Said) -> Said:
    """A report or a state of a real body, within what its agent may tell others.

    A message that breaks a bound of the wire is refused by everybody who reads it, so one long word would silence a vehicle.
    Words are cut, and end with an ellipsis then. Numbers become the nearest that is possible, and what is no number 0.
    """
    match said:
        case VehicleState(pose=pose):
            return msgspec.structs.replace(
                said,
                pose=Pose(
                    x_m=_between(pose.x_m, METRES_MAX),
                    y_m=_between(pose.y_m, METRES_MAX),
                    heading_rad=_between(pose.heading_rad, HEADING_MAX_RAD),
                ),
                next_node_s=max(0.0, _between(said.next_node_s, LONGEST_S)),
                speed_mps=_between(said.speed_mps, SPEED_MAX_MPS),
                battery_frac=max(0.0, _between(said.battery_frac, 1.0)),
                load_quantity=_count(said.load_quantity),
                problem=_words(said.problem),
                wait=said.wait and _wait(said.wait),
            )
        case ProblemRaised() | ActionFailed() | CycleFailed() | Broken():
            return msgspec.structs.replace(said, reason=_words(said.reason))
        case NodePassed():
            return msgspec.structs.replace(said, battery_frac=max(0.0, _between(said.battery_frac, 1.0)))
        case WorkcellState():
            return msgspec.structs.replace(said, broken=_words(said.broken), stock=_stock(said.stock))
        case StorageState():
            return msgspec.structs.replace(said, stock=_stock(said.stock))
        case DutyState():
            busy_until_s = said.busy_until_s
            if busy_until_s is not None:
                busy_until_s = _between(busy_until_s, LONGEST_S)
            return msgspec.structs.replace(said, label=_words(said.label), busy_until_s=busy_until_s)
        case DutyChanged():
            return msgspec.structs.replace(said, state=bounded(said.state))
        case _:
            return said


def _words(text: str) -> str:
    text = encodable(text)
    return text if len(text) <= WORDS_MAX else text[: WORDS_MAX - 1] + "…"


def _wait(wait: BodyWait) -> BodyWait:
    return BodyWait(
        what=_words(wait.what), since_s=_between(wait.since_s, LONGEST_S), until=_words(wait.until)
    )


def _between(value: float, most: float) -> float:
    return min(max(value, -most), most) if value == value else 0.0  # noqa: PLR0124 - NaN differs from itself


def _count(value: int) -> int:
    return min(max(value, 0), COUNT_MAX)


def _stock(stock: dict[str, int]) -> dict[str, int]:
    return {item: _count(count) for item, count in stock.items()}
