"""The gate of the delivery warehouses: its instructions and reports (see `dray.body`).

The gate itself (`Admit`, `GoodsArrived`, `GateProblem`, its `GateState`) is the body of its agent. A strategist uses the gate, too: it holds orders
there (`HoldOrder`, `OrderHeld`), and senses which ones it holds.
"""

from __future__ import annotations

from msgspec import field

from dray.messages.base import Part
from dray.messages.gate import GoalOf

EVERY_RELEASE = 2**53
"""The release number that closes an order for ever: after its cancellation or arrival no release is made."""


class Admit(Part, frozen=True):
    """Admit pieces of this goal up to a total, including those that have arrived.

    The gate is where a goal is fenced: if the goal was given to another machine meanwhile, the gate refuses its pieces from any
    vehicle. Answered with `GoodsArrived`, also when nothing changes. A total below the arrived number admits no more.
    """

    goal: str
    quantity: int
    of: GoalOf | None = None
    """The goal's order, item and machine, told with a new goal if a plant has several strategists; None if it has one."""
    arrived: int = 0
    """Pieces that have arrived, as its agent remembers. Only a people's gate uses it, when its own file was damaged."""


class HoldOrder(Part, frozen=True):
    """Hold an order, where a plant has several strategists: from now on only this strategist may have its goals admitted.

    Granted when nobody holds it, or when the holder's epoch is lower. Answered with `OrderHeld` either way.
    """

    order: str
    epoch: int
    over: int = 0
    """Releases up to this one have ended: no later holder may make anything of them. Sent by the holder."""
    again: int = 0
    """This release is made although it was said to have ended; 0 for none. Sent by the holder."""


class GoodsArrived(Part, frozen=True):
    """The number of arrived pieces of a goal: reported after every arrival and every `Admit`."""

    goal: str
    arrived: int
    admitted: int
    """Maximum pieces to admit; 0 means that the gate is shut and `arrived` is final. While that is in doubt, 1 at least."""
    vehicle: str = ""
    """The vehicle that brought the last ones; empty after an `Admit`, and where the gate cannot tell."""
    by_people: bool = False
    """Whether people count, later than goods arrive. See also `GateState.late`."""


class GateProblem(Part, frozen=True):
    """Why the gate counts nothing, or does not let a container in that may come in: reported at each change."""

    problem: str
    """In words for people, without goals; empty while all is well."""


class GateState(Part, frozen=True):
    """The gate's counts since it was built."""

    arrived: dict[str, int]
    """Pieces by goal, for every goal ever admitted and not forgotten; each of several strategists sees those of its own orders."""
    held: dict[str, int] = field(default_factory=dict)
    """The orders that this strategist holds, with their epochs; empty where there is one strategist."""
    people: bool = False
    """Whether it is operated by people, who report with `dray.body.Word`."""
    late: bool = False
    """Whether it counts later than goods arrive, as people do: containers wait there until their label was read."""
    problem: str = ""
    """See `GateProblem`."""
