"""Plain transports: a place is asked to have a load brought to it.

The destination coordinates the transport, since it counts the load: a machine, or the station of a storage. A machine also uses
them to have surplus parts fetched from it.
"""

from __future__ import annotations

from enum import StrEnum
from typing import Final

from dray.messages.base import Count, Id, IdOrNone, Message, Seconds
from dray.messages.kinds import DOCKS, GATEWAYS, MACHINES

THING: Final = ".thing"
"""Item name for one thing without master data, described by a text where it was called for. It is carried like any load and counted
in no stock, so it needs a source and a destination, but no place that keeps it. A plant's items begin with a letter, so none has
this name."""


class TransportState(StrEnum):
    """The state of a plain transport."""

    WAITING = "waiting"
    """It has no carrier."""
    ASSIGNED = "assigned"
    """A vehicle fetches it."""
    ON_BOARD = "on_board"
    DELIVERED = "delivered"
    CANCELLED = "cancelled"
    """A person has cancelled it, or it cannot be done."""


TRANSPORT_ENDED = frozenset({TransportState.DELIVERED, TransportState.CANCELLED})


class TransportWait(StrEnum):
    """Why a transport has no carrier."""

    NO_ROOM = "no_room"
    """The destination has no room for it yet."""
    SHORT = "short"
    """The source has too little, or does not answer."""
    NO_BID = "no_bid"
    """All vehicles were asked and refused, with reasons. It stays so while it is offered again."""
    UNDECIDED = "undecided"
    """It is being offered for the first time."""


class TransportRefusal(StrEnum):
    """Why a transport cannot be done."""

    NOT_KEPT_HERE = "not_kept_here"
    """The destination does not keep this item, or not as many."""
    NOT_KEPT_THERE = "not_kept_there"
    """The source does not keep this item."""
    TOO_LARGE = "too_large"
    """It is more than one load."""


class TransportOrdered(Message, said_by=GATEWAYS | MACHINES, frozen=True):
    """Asks the destination to have a load brought. Repeated until it is answered; the same transport twice is one."""

    transport: Id
    source: Id
    """The place where it is fetched: a storage, or a machine that has it in a buffer."""
    item: Id
    quantity: Count
    """One load: at most the lot of the material."""
    due_s: Seconds
    """When it should be there (plant clock)."""
    vehicle: IdOrNone = ""
    """The only vehicle that may carry it; empty for any."""
    vehicle_until_s: Seconds | None = None
    """Until when only that vehicle is asked (plant clock); None for always."""
    ability: IdOrNone = ""
    """An ability that its vehicle must have beside that of the load; empty for none. For a `THING`, the load's ability."""


class TransportCancelled(Message, said_by=GATEWAYS | MACHINES, frozen=True):
    """Cancels a transport, unless it is on board. Repeated until it is answered."""

    transport: Id


class TransportAnswered(Message, said_by=DOCKS, frozen=True):
    """The state of a transport: the answer to `TransportOrdered` and `TransportCancelled`."""

    transport: Id
    state: TransportState
    refused: TransportRefusal | None = None
    """Why it cannot be done, if that has cancelled it."""
