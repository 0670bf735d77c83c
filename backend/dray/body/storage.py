"""A storage with a dock: its instructions and reports."""

from __future__ import annotations

from dray.body.dock import Book, CloseDock, OpenDock
from dray.body.words import Word
from dray.messages.base import Part
from dray.messages.heartbeat import UnconfirmedLoad


class Refill(Part, frozen=True):
    """Have more of a material brought, because too little lies there. Harmless when it is on its way already."""

    item: str


class FillTo(Part, frozen=True):
    """Let a material that comes by itself fill no more than this room: the rest is for loads on their way.

    Vehicles' loads may lie above it. It holds until another one, also without the agent; before the first one the capacity holds.
    """

    item: str
    quantity: int


class StorageState(Part, frozen=True):
    """A storage's state."""

    stock: dict[str, int]
    """Pieces of every material."""
    seq: int
    """Number of stock changes reported since it was built; see `WorkcellState`."""
    opened: tuple[str, ...]
    """Vehicles for which the dock is open or opening: they have not taken their load yet."""
    answers: bool = False
    """Whether its dock takes time to open; see `WorkcellState`."""
    counts: bool = True
    """Whether it counts what vehicles bring and take; see `WorkcellState`."""
    uncounted: tuple[str, ...] = ()
    """Materials with an unknown count until somebody counts: their `stock` is a lower bound, of later arrivals only."""
    measured: tuple[str, ...] = ()
    """Materials whose level its controller measures: `stock` is corrected by that, so nobody is asked to count them."""
    people: bool = False
    """Whether it is operated by people, who report with `Word`."""
    loads: tuple[UnconfirmedLoad, ...] = ()
    """Unconfirmed loads, where people operate it; see `WorkcellState`."""
    gone: tuple[str, ...] = ()
    """Expected reports of vehicles without permission, where people operate it; see `WorkcellState`."""


StorageInstruction = OpenDock | CloseDock | Book | Refill | FillTo | Word
