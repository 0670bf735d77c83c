"""A machine's body is its workcell, cycles, buffers and a dock: what it is told and what it tells."""

from __future__ import annotations

from dray.body.dock import Book, CloseDock, DockReady, OpenDock, StockChanged
from dray.body.documents import DocumentRead, ReadDocument
from dray.body.words import Word, WordTaken
from dray.messages.base import Part
from dray.messages.heartbeat import UnconfirmedLoad
from dray.messages.problem import NOTHING_KNOWN, Problem
from dray.messages.product import BillLine


class StartCycle(Part, frozen=True):
    """Make one piece: takes the bill of material out of the buffers, puts a piece into the goods."""

    product: str
    bill: tuple[BillLine, ...] = ()
    """What it takes; empty for what the workcell was set up with."""
    cycle_s: float = 0.0
    """How long a piece takes at full speed, for a product that the workcell was not set up for; 0 where nobody says it."""


class ResetFault(Part, frozen=True):
    """A person says that the fault is gone: work again, if the sensors find nothing wrong."""


class SetPace(Part, frozen=True):
    """Work at a part of the own speed, from the next cycle on."""

    speed_frac: float
    """Above 0, and at most 1."""


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


class Broken(Part, frozen=True):
    """The machine has stopped; a running cycle pauses. Said again when more is known."""

    reason: str
    problem: Problem = NOTHING_KNOWN
    """Its kind, and what is known of it: say what is known, and no more."""
    resettable: bool = False
    """The sensors find nothing wrong any more; it stands until `ResetFault`."""


class Repaired(Part, frozen=True):
    """The machine works again; a paused cycle goes on."""


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
