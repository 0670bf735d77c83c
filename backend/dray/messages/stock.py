"""What lies in a storage, and who counts on it: said between its station and those who have material fetched there.

Nobody announces a transport before a station has set the material aside for it. A reservation lapses when nobody
asks for it again, so that whoever has failed holds nothing back for long.
"""

from __future__ import annotations

from dray.messages.base import Count, Id, Message
from dray.messages.kinds import DOCKS


class StockAsked(Message, said_by=DOCKS, frozen=True):
    """A coordinator asks a station to set pieces aside for one task.

    Said again, it renews the reservation, or the place in the queue.
    """

    task: Id
    epoch: Count
    """Pieces that were fetched for an earlier epoch are gone: a higher one asks for others."""
    item: Id
    quantity: Count


class StockReserved(Message, said_by=DOCKS, frozen=True):
    """The pieces are set aside for this task. It lapses some time after it was asked for last."""

    task: Id
    epoch: Count
    item: Id
    quantity: Count


class StockShort(Message, said_by=DOCKS, frozen=True):
    """There is not enough that is promised to nobody.

    The task is in the queue as long as it is asked for again; `StockReserved` follows when its turn has come. Also
    said when a reservation could not be kept.
    """

    task: Id
    epoch: Count
    item: Id
    free: Count
    """Pieces that lie there and are promised to nobody."""


class StockFreed(Message, said_by=DOCKS, frozen=True, omit_defaults=True):
    """The coordinator does not count on pieces for this task any more."""

    task: Id
    fetched: bool = False
    """They were fetched in the epoch of the `StockReserved` that is answered, or may have been: a carrier was bound in it, or nobody remembers."""
