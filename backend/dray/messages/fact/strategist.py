"""What the strategist tells: orders, and the goals that they became."""

from __future__ import annotations

from dray.messages.base import Count, Id, IdOrNone, Part, Seconds
from dray.messages.fact.base import Fact
from dray.messages.reason import Reason


class OrderAccepted(Fact, frozen=True):
    """The strategist split an order into goals."""

    order: Id
    goals: tuple[Id, ...]


class GoalContracted(Fact, frozen=True):
    """A machine took a goal."""

    goal: Id
    order: Id
    item: Count
    product: Id
    quantity: Count
    machine: Id
    finish_s: Seconds


class GoodsDelivered(Fact, frozen=True):
    """Finished goods of a goal reached the delivery warehouse."""

    goal: Id
    order: Id
    item: Count
    product: Id
    quantity: Count
    """In this transport."""
    delivered: Count
    """Of this goal, with these."""


class GoalLost(Fact, frozen=True):
    """A machine has failed with a goal; what had not arrived is announced again under another name."""

    goal: Id
    machine: Id
    arrived: Count
    """Pieces that count, once."""
    successor: IdOrNone
    """The new goal for the rest; empty when nothing was left to make."""


class GoalWithdrawn(Fact, frozen=True):
    """A machine need not make a goal any more, because its order was taken back."""

    goal: Id
    machine: Id
    arrived: Count
    """Pieces that count, once."""


class MachineFailure(Part, frozen=True):
    """A machine that makes nothing now."""

    machine: Id
    reason: Reason
    """`SILENT` or `BROKEN`."""


class GoalWaits(Fact, frozen=True):
    """Nobody who lives can make this goal; only its order waits (paper, case 1)."""

    goal: Id
    order: Id
    machines: tuple[MachineFailure, ...]
    """All that could make it."""


class OrderProgressed(Fact, frozen=True):
    """How much of an order is made and delivered, over all its goals."""

    order: Id
    made: Count
    delivered: Count
    quantity: Count


class OrderFulfilled(Fact, frozen=True):
    """All of an order is in the delivery warehouse."""

    order: Id


class OrderDropped(Fact, frozen=True):
    """A cancelled order left the strategist's books."""

    order: Id


class OrderReturned(Fact, frozen=True):
    """An order that was taken back left the strategist's books; it may be released again."""

    order: Id
    release: Count
    outstanding: tuple[Count, ...]
    """Per item, what had not arrived."""
