"""Orders, on their way from the gateway to the strategist; and what a change of one is for the machines that work at it."""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta

from dray.messages.base import Count, Id, Message, Part, Seconds
from dray.messages.kinds import GATEWAYS, MACHINES, STRATEGISTS
from dray.messages.product import PartDefinition, ProductDefinition

PARTS_MAX = 200
"""Parts on all levels below one product."""


class OrderItem(Part, frozen=True):
    """One line of an order: what is still to be delivered of it."""

    product: Id
    quantity: Count
    definition: ProductDefinition | None = None
    """The product as its master data have it; None for one that is made as the plant file says."""
    arrived: Count = 0
    """Pieces of it that had arrived before: with these all that was ordered."""
    parts: Annotated[tuple[PartDefinition, ...], Meta(max_length=PARTS_MAX)] = ()
    """Parts on all levels below it, as far as their master data have them; all others are made as the plant file says."""


class OrderReleased(Message, said_by=GATEWAYS, frozen=True):
    """Make this. Repeated until the strategist answers; the same order twice is one order.

    `items` hold what is outstanding: after a restart less than was ordered. One with a higher `change` than what is in work changes that.
    """

    order: Id
    items: tuple[OrderItem, ...]
    due_s: Seconds
    """By when all of it is wanted in the delivery warehouse (plant clock)."""
    release: Count = 1
    """How often this order was released, with this time: one that was taken back may be released again."""
    change: Count = 0
    """How often people have changed it."""


class OrderTaken(Message, said_by=STRATEGISTS, frozen=True):
    """The strategist has the order and will see to it."""

    order: Id
    release: Count = 1
    """Which release of it this answers."""
    fulfilled: bool = False
    """All of it has arrived: nothing is to be done any more, whoever has missed the facts about that."""
    change: Count = 0
    """The last change that was taken. A change is answered when the machines have said what they keep."""
    quantities: tuple[Count, ...] = ()
    """Per item, all that will have been delivered; empty where it was asked for without a change, or is not known any more."""


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
    """Which release is meant; a later one stays."""


class RevocationTaken(Message, said_by=STRATEGISTS, frozen=True):
    """The strategist does not work at this release of an order any more, and will not begin to.

    Said only when the gate of the delivery warehouses is shut for all of its goals and has counted.
    """

    order: Id
    release: Count
    outstanding: tuple[Count, ...]
    """Per item, what had not arrived when the gate was shut: what another release has to order. Empty when
    the strategist did not work at this release: it has ended, or never came."""


class StrategistHeartbeat(Message, said_by=STRATEGISTS, signed="strategist", frozen=True):
    """What a strategist tells the others of its plant, once a second: that it is there, and how much it has in work."""

    strategist: Id
    incarnation: Count
    seq: Count
    at_s: Seconds
    orders: Count
    """Orders that it works at: its bid for the next one."""


class HolderChanged(Message, said_by=STRATEGISTS, frozen=True):
    """Another strategist has taken an order over: from now on it speaks for all goals of that order. Said again until the machine's heartbeat shows it."""

    order: Id
    epoch: Count
    """With which it holds the order; a lower one than is known counts for nothing."""


class GoalRevised(Message, said_by=STRATEGISTS, frozen=True):
    """The strategist changes a goal: less of it is wanted, or at another time. Said again until the machine's heartbeat shows it."""

    task: Id
    epoch: Count
    quantity: Count
    """As little as this would do; more than the machine has taken is another goal."""
    deadline_s: Seconds
    """When it should be done now (plant clock)."""


class GoalRevisionTaken(Message, said_by=MACHINES, frozen=True):
    """What a machine makes of a goal after that: what it has begun it keeps."""

    task: Id
    epoch: Count
    asked: Count
    """The quantity that this answers."""
    quantity: Count
