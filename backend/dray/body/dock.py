"""The dock of a workcell or a storage, and the loads that vehicles move there."""

from __future__ import annotations

from dray.messages.base import Part


class OpenDock(Part, frozen=True):
    """Let this vehicle load or unload, once. The dock stays shut for all others."""

    vehicle: str
    item: str
    quantity: int


class DockReady(Part, frozen=True):
    """The dock is open for this vehicle: it may load or unload now. Reported by a body that `answers`."""

    vehicle: str


class CloseDock(Part, frozen=True):
    """Shut the dock for this vehicle; harmless when it was never open. Sent again: the vehicle has left, without another report."""

    vehicle: str


class Book(Part, frozen=True):
    """A vehicle's own report of a transfer, for a body that does not count.

    Answered with `StockChanged`, as if the body had seen it. A repetition, by this or a later life of the agent, gets the same answer
    and books nothing.
    """

    vehicle: str
    item: str
    change: int
    """Pieces; negative when something was taken."""
    task: str
    """The transport that moved them."""
    epoch: int
    """The epoch of the transport."""


class StockChanged(Part, frozen=True):
    """A vehicle or a person has put something in or taken something out."""

    item: str
    change: int
    """Pieces; negative when something was taken."""
    seq: int
    """The number of this change of the stock; see `WorkcellState.seq`."""
    vehicle: str = ""
    counted: bool = False
    """Whether a person's count corrected the stock, without a transfer."""
