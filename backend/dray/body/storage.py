"""A storage, which has a dock as a workcell has: what it is told and what it tells."""

from __future__ import annotations

from dray.body.dock import Book, CloseDock, OpenDock
from dray.body.words import Word
from dray.messages.base import Part
from dray.messages.heartbeat import UnconfirmedLoad


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
