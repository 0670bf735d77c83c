"""Orders on their way from the gateway to the strategist, and their changes on the way to the machines."""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta

from dray.messages.base import Count, Id, Message, Part, Seconds
from dray.messages.kinds import GATEWAYS, MACHINES, STRATEGISTS
from dray.messages.product import PartDefinition, ProductDefinition

PARTS_MAX = 200
"""Maximum parts on all levels below one product."""


class OrderItem(Part, frozen=True):
    """One line of an order, with the quantity still to be delivered."""

    product: Id
    quantity: Count
    definition: ProductDefinition | None = None
    """The product by its master data; None for one that is made by the plant file."""
    arrived: Count = 0
    """Pieces that had arrived before; the ordered quantity is the sum of both."""
    parts: Annotated[tuple[PartDefinition, ...], Meta(max_length=PARTS_MAX)] = ()
    """Parts with master data on all levels below it; all others are made by the plant file."""


class OrderReleased(Message, said_by=GATEWAYS, frozen=True):
    """Make this order. Repeated until the strategist answers; the same order twice is one order.

    `items` hold what is outstanding: after a restart less than was ordered. A higher `change` than that in work changes the order.
    """

    order: Id
    items: tuple[OrderItem, ...]
    due_s: Seconds
    """When all of it must be in the delivery warehouse (plant clock)."""
    release: Count = 1
    """Number of this release: an order that was taken back may be released again."""
    change: Count = 0
    """How often people have changed it."""


class OrderTaken(Message, said_by=STRATEGISTS, frozen=True):
    """The strategist has taken the order."""

    order: Id
    release: Count = 1
    """The release that this answers."""
    fulfilled: bool = False
    """Whether all of it has arrived, for agents that have missed the facts about that."""
    change: Count = 0
    """The last change taken. A change is answered when the machines have said what they keep."""
    quantities: tuple[Count, ...] = ()
    """Final delivered quantity per item; empty without a change, or when it is not known any more."""


class OrderCancelled(Message, said_by=GATEWAYS, frozen=True):
    """Stop working at this order: its goals are withdrawn. Repeated until the strategist answers."""

    order: Id


class CancellationTaken(Message, said_by=STRATEGISTS, frozen=True):
    """The strategist does not work at this order, and will not begin to."""

    order: Id


class OrderRevoked(Message, said_by=GATEWAYS, frozen=True):
    """Take back the start of an order: its goals are withdrawn. Repeated until the strategist answers."""

    order: Id
    release: Count
    """The release that is taken back; a later one stays."""


class RevocationTaken(Message, said_by=STRATEGISTS, frozen=True):
    """The strategist does not work at this release of an order any more, and will not begin to.

    Sent only when the gate of the delivery warehouses is shut for all its goals and has counted.
    """

    order: Id
    release: Count
    outstanding: tuple[Count, ...]
    """Pieces per item that had not arrived when the gate was shut, for the next release. Empty when the strategist did not work at
    this release: it has ended, or never came."""


class StrategistHeartbeat(Message, said_by=STRATEGISTS, signed="strategist", frozen=True):
    """A strategist's heartbeat to the other strategists, once a second."""

    strategist: Id
    incarnation: Count
    seq: Count
    at_s: Seconds
    orders: Count
    """Number of orders in work: its bid for the next one."""


class HolderChanged(Message, said_by=STRATEGISTS, frozen=True):
    """The sender has taken an order over, and speaks for all its goals. Repeated until the machine's heartbeat shows it."""

    order: Id
    epoch: Count
    """Epoch under which it holds the order. One below the known epoch, or the same of another strategist, is ignored for as long as such a
    message may be late (`dray.messages.overtaken`)."""


class GoalRevised(Message, said_by=STRATEGISTS, frozen=True):
    """The strategist changes a goal's quantity or deadline. Repeated until the machine's heartbeat shows it."""

    task: Id
    epoch: Count
    quantity: Count
    """The quantity that would suffice; an increase is another goal."""
    deadline_s: Seconds
    """The new deadline (plant clock)."""


class GoalRevisionTaken(Message, said_by=MACHINES, frozen=True):
    """A machine's quantity of a goal after a revision; it keeps pieces that it has begun."""

    task: Id
    epoch: Count
    asked: Count
    """The quantity that this answers."""
    quantity: Count
