"""Facts of the strategist: orders and their goals."""

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
    """Epoch under which it holds the order; 0 in a plant with one strategist."""


class OrderTakenOver(Fact, told_by=STRATEGISTS, frozen=True):
    """The strategist continues an order whose holder was silent."""

    order: Id
    epoch: Count
    """Epoch under which it holds the order."""
    goals: tuple[Id, ...]
    """Goals that machines continue, and new ones for pieces that no machine makes."""


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
    """The product of which it is a part; empty for goods for the delivery warehouse."""
    held: Count = 0
    """Epoch under which its order is held; see `OrderAccepted`. The next holder uses a higher one."""


class GoodsDelivered(Fact, told_by=STRATEGISTS, frozen=True):
    """Finished goods of a goal reached the delivery warehouse."""

    goal: Id
    order: Id
    item: Count
    product: Id
    quantity: Count
    """Pieces of this transport; after a takeover of the order, all pieces that had arrived before, some of them recorded already."""
    delivered: Count
    """Pieces of this goal so far, these included."""


class GoalLost(Fact, told_by=STRATEGISTS, frozen=True):
    """A machine has failed with a goal; its missing pieces are announced again under another name."""

    goal: Id
    machine: Id
    arrived: Count
    """Arrived pieces, each counted once."""
    successor: IdOrNone
    """The new goal for the rest; empty when nothing was left to make."""
    held: Count = 0
    """See `GoalContracted`."""


class GoalWithdrawn(Fact, told_by=STRATEGISTS, frozen=True):
    """A machine need not make a goal any more: its order was taken back.

    A goal of parts is also withdrawn when its order has ended, when its machine has failed, or when nobody needs its parts any more; missing
    parts become another goal.
    """

    goal: Id
    machine: Id
    arrived: Count
    """Arrived pieces, each counted once; 0 for parts, which go to no warehouse."""
    held: Count = 0
    """See `GoalContracted`."""


class GoalReduced(Fact, told_by=STRATEGISTS, frozen=True):
    """A goal's quantity was reduced, and its machine has agreed."""

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
    """Final delivered quantity per item."""


class MachineFailure(Part, frozen=True):
    """A machine that has failed."""

    machine: Id
    reason: Reason
    """`SILENT` or `BROKEN`."""


class GoalWaits(Fact, told_by=STRATEGISTS, frozen=True):
    """No working machine can make this goal; only its order waits (paper, case 1)."""

    goal: Id
    order: Id
    machines: tuple[MachineFailure, ...]
    """All machines that could make it."""


class OrderProgressed(Fact, told_by=STRATEGISTS, frozen=True):
    """Pieces of an order made and delivered, over all its goals."""

    order: Id
    made: Count
    delivered: Count
    quantity: Count


class OrderFulfilled(Fact, told_by=STRATEGISTS, frozen=True):
    """All of an order is in the delivery warehouse."""

    order: Id


class OrderDropped(Fact, told_by=STRATEGISTS, frozen=True):
    """The strategist has dropped a cancelled order."""

    order: Id


class OrderReturned(Fact, told_by=STRATEGISTS, frozen=True):
    """The strategist has dropped an order that was taken back; it may be released again."""

    order: Id
    release: Count
    outstanding: tuple[Count, ...]
    """Pieces per item that had not arrived."""
