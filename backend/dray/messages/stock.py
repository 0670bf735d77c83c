"""Reservations of material in a storage: messages between its station and the coordinators that have material fetched there.

A coordinator announces a transport only when a station has reserved the material. A reservation lapses unless it is requested
again, so that a failed coordinator holds nothing back for long.
"""

from __future__ import annotations

from dray.messages.base import Count, Id, Message
from dray.messages.kinds import DOCKS


class StockAsked(Message, said_by=DOCKS, frozen=True):
    """A coordinator asks a station to reserve pieces for one task.

    Sent again, it renews the reservation, or the place in the queue.
    """

    task: Id
    epoch: Count
    """Epoch of the task: a higher one asks for new pieces, as those of an earlier epoch may be fetched already."""
    item: Id
    quantity: Count


class StockReserved(Message, said_by=DOCKS, frozen=True):
    """The pieces are reserved for this task. The reservation lapses some time after the last request."""

    task: Id
    epoch: Count
    item: Id
    quantity: Count


class StockShort(Message, said_by=DOCKS, frozen=True):
    """The station has too few free pieces.

    The task stays in the queue while its request is repeated; `StockReserved` follows when its turn comes. Also sent when a
    reservation could not be kept.
    """

    task: Id
    epoch: Count
    item: Id
    free: Count
    """Pieces in stock that are not reserved."""


class StockFreed(Message, said_by=DOCKS, frozen=True, omit_defaults=True):
    """The coordinator does not need the pieces for this task any more, or not those for an earlier epoch of it."""

    task: Id
    fetched: bool = False
    """Whether they may have been fetched in the epoch of the answered `StockReserved`: it had a carrier, or that is unknown."""
    epoch: Count = 0
    """That epoch, if the task goes on in a later one, whose reservation stays; 0 for the whole task."""
    known: bool = False
    """Whether the coordinator knows that they were fetched; otherwise it cannot exclude it."""
