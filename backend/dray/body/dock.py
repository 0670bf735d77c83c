"""A dock, of a workcell or a storage, and the loads that vehicles bring to it and take from it."""

from __future__ import annotations

from dray.messages.base import Part


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
