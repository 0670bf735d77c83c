"""What the strategist tells: orders, and the goals that they became."""

from __future__ import annotations

from dray.messages.base import Count, Id, IdOrNone, Part, Seconds
from dray.messages.fact.base import Fact
from dray.messages.kinds import STRATEGISTS
from dray.messages.reason import Reason


class OrderAccepted(Fact, told_by=STRATEGISTS, frozen=True):
    """The strategist split an order into goals."""

    order: Id
    goals: tuple[Id, ...]
    held: Count = 0
    """The epoch with which it holds the order; 0 where a plant has one strategist."""


class OrderTakenOver(Fact, told_by=STRATEGISTS, frozen=True):
    """The strategist goes on with an order whose holder was silent."""

    order: Id
    epoch: Count
    """With which it holds the order."""
    goals: tuple[Id, ...]
    """Those that machines go on with, and new ones for what nobody makes."""


class GoalContracted(Fact, told_by=STRATEGISTS, frozen=True):
    """A machine took a goal."""

    goal: Id
    order: Id
    item: Count
    product: Id
    quantity: Count
    machine: Id
    finish_s: Seconds
    part_of: IdOrNone = ""
    """The product for which it is a part; empty for what goes to the delivery warehouse."""
    held: Count = 0
    """The epoch with which its order is held; see `OrderAccepted`. Whoever holds it next tells with a higher one."""


class GoodsDelivered(Fact, told_by=STRATEGISTS, frozen=True):
    """Finished goods of a goal reached the delivery warehouse."""

    goal: Id
    order: Id
    item: Count
    product: Id
    quantity: Count
    """In this transport; after a takeover of the order all that had arrived before, which may have been told in part."""
    delivered: Count
    """Of this goal, with these."""


class GoalLost(Fact, told_by=STRATEGISTS, frozen=True):
    """A machine has failed with a goal; what had not arrived is announced again under another name."""

    goal: Id
    machine: Id
    arrived: Count
    """Pieces that count, once."""
    successor: IdOrNone
    """The new goal for the rest; empty when nothing was left to make."""
    held: Count = 0
    """See `GoalContracted`."""


class GoalWithdrawn(Fact, told_by=STRATEGISTS, frozen=True):
    """A machine need not make a goal any more: its order was taken back.

    A goal of parts also because its order has ended, or its machine has failed: what is lacking then is another goal.
    """

    goal: Id
    machine: Id
    arrived: Count
    """Pieces that count, once; 0 of parts, which arrive nowhere."""
    held: Count = 0
    """See `GoalContracted`."""


class GoalReduced(Fact, told_by=STRATEGISTS, frozen=True):
    """Less of a goal is wanted, and its machine has agreed to make no more than this."""

    goal: Id
    order: Id
    item: Count
    product: Id
    machine: Id
    quantity: Count
    held: Count = 0
    """See `GoalContracted`."""


class OrderChanged(Fact, told_by=STRATEGISTS, frozen=True):
    """A change of an order is done, as far as it was still possible."""

    order: Id
    release: Count
    change: Count
    quantities: tuple[Count, ...]
    """Per item, all that will have been delivered."""


class MachineFailure(Part, frozen=True):
    """A machine that makes nothing now."""

    machine: Id
    reason: Reason
    """`SILENT` or `BROKEN`."""


class GoalWaits(Fact, told_by=STRATEGISTS, frozen=True):
    """Nobody who lives can make this goal; only its order waits (paper, case 1)."""

    goal: Id
    order: Id
    machines: tuple[MachineFailure, ...]
    """All that could make it."""


class OrderProgressed(Fact, told_by=STRATEGISTS, frozen=True):
    """How much of an order is made and delivered, over all its goals."""

    order: Id
    made: Count
    delivered: Count
    quantity: Count


class OrderFulfilled(Fact, told_by=STRATEGISTS, frozen=True):
    """All of an order is in the delivery warehouse."""

    order: Id


class OrderDropped(Fact, told_by=STRATEGISTS, frozen=True):
    """A cancelled order left the strategist's books."""

    order: Id


class OrderReturned(Fact, told_by=STRATEGISTS, frozen=True):
    """An order that was taken back left the strategist's books; it may be released again."""

    order: Id
    release: Count
    outstanding: tuple[Count, ...]
    """Per item, what had not arrived."""
