"""The gate of the delivery warehouses: what it is told and what it tells (see `dray.body`).

The gate itself (`Admit`, `GoodsArrived`, its `GateState`) is the body of its agent. To a strategist the agent and the gate are one: it has orders held
there, too (`HoldOrder`, `OrderHeld`), and senses which it holds.
"""

from __future__ import annotations

from msgspec import field

from dray.messages.base import Part
from dray.messages.gate import GoalOf

EVERY_RELEASE = 2**53
"""An order that was cancelled or has arrived is not made, however often it is released."""


class Admit(Part, frozen=True):
    """Let in as many pieces of this goal, those that have arrived included, and no more.

    The gate is where a goal is fenced: pieces of a goal that was given to another machine meanwhile
    are not let in, whoever brings them. Answered with `GoodsArrived`, also when nothing changes.
    Less than have arrived already means: no more.
    """

    goal: str
    quantity: int
    of: GoalOf | None = None
    """Told with a new goal where a plant has several strategists; None where it has one."""
    arrived: int = 0
    """How many are in, as its agent remembers: people's gate takes it up where its own file was damaged. 0 to any other."""


class HoldOrder(Part, frozen=True):
    """Hold an order, where a plant has several strategists: from now on its goals are admitted on this one's word alone.

    Granted when nobody holds it, or the holder has it with a lower epoch. Answered with `OrderHeld` either way.
    """

    order: str
    epoch: int
    over: int = 0
    """Releases up to this one have ended: nothing is to be made of them any more, whoever takes the order over. Said by the holder."""


class GoodsArrived(Part, frozen=True):
    """How many pieces of a goal are in by now: said after every arrival and every `Admit`."""

    goal: str
    arrived: int
    admitted: int
    """How many may get in at all; 0 tells that the gate is shut and `arrived` the last word."""
    vehicle: str = ""
    """Who has brought the last ones; empty after an `Admit`, and where the gate cannot tell."""
    by_people: bool = False
    """People count, later than goods come."""


class GateState(Part, frozen=True):
    """What the gate has counted since it was built."""

    arrived: dict[str, int]
    """Pieces by goal, for every goal that was ever admitted and is not forgotten; of several strategists each has those of its orders."""
    held: dict[str, int] = field(default_factory=dict)
    """The orders that this strategist holds, with their epochs; empty where there is one strategist."""
    people: bool = False
    """Whether it is people, whose words (`dray.body.Word`) it takes."""
