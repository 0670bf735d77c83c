"""Plain transports: somebody asks a place to have something brought to it.

The place where the load is to go coordinates the transport, since it counts what is put down: a machine, or the station of a storage. A
machine asks likewise for parts to be fetched that it has and does not need.
"""

from __future__ import annotations

from enum import StrEnum
from typing import Final

from dray.messages.base import Count, Id, IdOrNone, Message, Seconds
from dray.messages.kinds import DOCKS, GATEWAYS, MACHINES

THING: Final = ".thing"
"""As an item: one thing without master data (a text at whoever has called for it). It is carried as everything else and counted in no stock: it needs a
place where it is fetched and one where it goes, and no place that keeps it. No item of a plant is called so: those begin with a letter."""


class TransportState(StrEnum):
    """How far a plain transport is."""

    WAITING = "waiting"
    """Nobody carries it."""
    ASSIGNED = "assigned"
    """A vehicle fetches it."""
    ON_BOARD = "on_board"
    DELIVERED = "delivered"
    CANCELLED = "cancelled"
    """By a person, or since it cannot be done."""


TRANSPORT_ENDED = frozenset({TransportState.DELIVERED, TransportState.CANCELLED})


class TransportWait(StrEnum):
    """Why nobody carries it."""

    NO_ROOM = "no_room"
    """Where it is to go there is no room for it yet."""
    SHORT = "short"
    """Where it is to be fetched there is not enough, or nobody answers."""
    NO_BID = "no_bid"
    """All vehicles were asked, and none could take it; they have told why. It stays so while it is offered again."""
    UNDECIDED = "undecided"
    """It is being offered for the first time."""


class TransportRefusal(StrEnum):
    """Why it cannot be done."""

    NOT_KEPT_HERE = "not_kept_here"
    """The place where it is to go does not keep this, or not so much."""
    NOT_KEPT_THERE = "not_kept_there"
    """The place where it is to be fetched does not keep this."""
    TOO_LARGE = "too_large"
    """It is more than one load."""


class TransportOrdered(Message, said_by=GATEWAYS | MACHINES, frozen=True):
    """Have this brought to you. Repeated until it is answered; the same transport twice is one."""

    transport: Id
    source: Id
    """Where it is fetched: a storage, or a machine that has it in a buffer."""
    item: Id
    quantity: Count
    """One load: at most the lot of the material."""
    due_s: Seconds
    """When it should be there (plant clock)."""
    vehicle: IdOrNone = ""
    """The only one that may carry it; empty for any."""
    vehicle_until_s: Seconds | None = None
    """Until when only that one is asked, and then any (plant clock); None for always."""
    ability: IdOrNone = ""
    """What its vehicle must be able to carry, beside what the load asks for; empty for nothing. Of a `THING` it is what the load asks for."""


class TransportCancelled(Message, said_by=GATEWAYS | MACHINES, frozen=True):
    """Do not have it brought, unless it is on board. Repeated until it is answered."""

    transport: Id


class TransportAnswered(Message, said_by=DOCKS, frozen=True):
    """How far a transport is, in answer to either."""

    transport: Id
    state: TransportState
    refused: TransportRefusal | None = None
    """Why it cannot be done, where that is why it was cancelled."""
