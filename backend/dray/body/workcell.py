"""A machine's body is its workcell (cycles, buffers and a dock): its instructions and reports."""

from __future__ import annotations

from dray.body.dock import Book, CloseDock, DockReady, OpenDock, StockChanged
from dray.body.documents import DocumentRead, ReadDocument
from dray.body.words import Word, WordTaken
from dray.messages.base import Part
from dray.messages.heartbeat import UnconfirmedLoad
from dray.messages.problem import NOTHING_KNOWN, Problem
from dray.messages.product import BillLine


class StartCycle(Part, frozen=True):
    """Make one piece: take the bill of material out of the buffers, and put a piece into the goods."""

    product: str
    bill: tuple[BillLine, ...] = ()
    """The bill of material; empty for the configured one."""
    cycle_s: float = 0.0
    """Seconds per piece at full speed, for a product that is not configured; 0 where unknown."""


class ResetFault(Part, frozen=True):
    """A person reports that the fault is gone: resume work, if the sensors find nothing wrong."""


class SetPace(Part, frozen=True):
    """Work at a fraction of the top speed, from the next cycle on."""

    speed_frac: float
    """Above 0, and at most 1."""


WorkcellInstruction = StartCycle | OpenDock | CloseDock | Book | ResetFault | SetPace | ReadDocument | Word


class CycleDone(Part, frozen=True):
    """A piece is finished and lies in the goods, or was bad and is gone."""

    product: str
    seq: int
    """The number of this change of the stock, without effect for a bad piece; see `WorkcellState.seq`."""
    bad: bool = False
    """The piece is bad: it lies nowhere, and its material is used up."""


class CycleFailed(Part, frozen=True):
    """A cycle could not start; nothing was consumed."""

    product: str
    reason: str


class Broken(Part, frozen=True):
    """The machine has stopped; a running cycle pauses. Reported again when more is known."""

    reason: str
    problem: Problem = NOTHING_KNOWN
    """Its kind, and the known details: report only what is known."""
    resettable: bool = False
    """The sensors find nothing wrong any more; the machine waits for `ResetFault`."""


class Repaired(Part, frozen=True):
    """The machine works again; a paused cycle resumes."""


WorkcellReport = (
    CycleDone | CycleFailed | StockChanged | DockReady | Broken | Repaired | DocumentRead | WordTaken
)


class WorkcellState(Part, frozen=True):
    """A workcell's state.

    A state may be sensed before the agent hears the reports that explain it, or told after them. So the reported changes of the
    stock have numbers: if the agent has not heard exactly up to `seq`, this stock belongs to another moment.
    """

    stock: dict[str, int]
    """Pieces of every material and product, without those in a running cycle."""
    seq: int
    """Number of stock changes reported since it was built; `stock` contains all of them."""
    cycling: str
    """The product of the running cycle; empty for none."""
    broken: str
    """Why it is stopped; empty when it works."""
    counts: bool = True
    """Whether it counts what vehicles bring and take. Otherwise it reports no transfer by itself: its agent sends `Book` for each
    report of a vehicle, and the stock is as reliable as these."""
    about_problem: Problem = NOTHING_KNOWN
    """The known details of why it is stopped; `NOTHING_KNOWN` where it works."""
    resettable: bool = False
    """It is stopped, and waits only for `ResetFault`."""
    paces: bool = False
    """Whether it can work at reduced speed."""
    answers: bool = False
    """Whether its dock takes time to open: each `OpenDock` is answered with a `DockReady`."""
    people: bool = False
    """Whether it is operated by people, who report with `Word`."""
    loads: tuple[UnconfirmedLoad, ...] = ()
    """Loads moved by vehicles' own reports and not confirmed by people yet, the oldest first; only where people operate it."""
    opened: tuple[str, ...] = ()
    """Vehicles for which its dock is open or opening, where it remembers them over its agent's lives."""
    let_in: OpenDock | None = None
    """Which of these was let in, and to move what, where it remembers that; None for none."""
    gone: tuple[str, ...] = ()
    """Vehicles without permission whose own report of their loads is still expected; only where people operate it."""
