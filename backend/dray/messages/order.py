"""Orders, on their way from the gateway to the strategist."""

from __future__ import annotations

from dray.messages.base import Count, Id, Message, Part, Seconds
from dray.messages.product import ProductDefinition


class OrderItem(Part, frozen=True):
    """One line of an order: what is still to be delivered of it."""

    product: Id
    quantity: Count
    definition: ProductDefinition | None = None
    """The product as its master data have it; None for one that is made as the plant file says."""


class OrderReleased(Message, frozen=True):
    """Make this. Repeated until the strategist answers; the same order twice is one order.

    `items` hold what is outstanding: after a restart less than was ordered.
    """

    order: Id
    items: tuple[OrderItem, ...]
    due_s: Seconds
    """When all of it should be in the delivery warehouse (plant clock)."""
    release: Count = 1
    """How often this order was released, with this time: one that was taken back may be released again."""


class OrderTaken(Message, frozen=True):
    """The strategist has the order and will see to it."""

    order: Id
    release: Count = 1
    """Which release of it this answers."""
    fulfilled: bool = False
    """All of it has arrived: nothing is to be done any more, whoever has missed the facts about that."""


class OrderCancelled(Message, frozen=True):
    """Stop working at this order: its goals are withdrawn. Repeated until the strategist answers."""

    order: Id


class CancellationTaken(Message, frozen=True):
    """The strategist does not work at this order, and will not begin to."""

    order: Id


class OrderRevoked(Message, frozen=True):
    """Take back the start of an order: its goals are withdrawn. Repeated until the strategist answers."""

    order: Id
    release: Count
    """Which release is meant; a later one stays."""


class RevocationTaken(Message, frozen=True):
    """The strategist does not work at this release of an order any more, and will not begin to.

    Said only when the gate of the delivery warehouses is shut for all of its goals and has counted.
    """

    order: Id
    release: Count
    outstanding: tuple[Count, ...]
    """Per item, what had not arrived when the gate was shut: what another release has to order. Empty when
    the strategist did not work at this release: it has ended, or never came."""
