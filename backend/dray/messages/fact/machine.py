"""Facts of a machine: its status, and the pieces that it has made."""

from __future__ import annotations

from dray.messages.base import Count, Id, IdOrNone, Seconds, Text
from dray.messages.fact.base import Fact
from dray.messages.heartbeat import MachineStatus
from dray.messages.kinds import MACHINES


class MachineStatusChanged(Fact, told_by=MACHINES, frozen=True):
    """The machine began, starved, was blocked, broke or stopped."""

    status: MachineStatus
    product: IdOrNone = ""
    reason: Text = ""


class PromiseMoved(Fact, told_by=MACHINES, frozen=True):
    """The machine will finish a goal at another time than promised, because the goals before it or its set speed have changed.

    The first promise stands in `GoalContracted`. This is the one that holds now.
    """

    goal: Id
    finish_s: Seconds
    """Promised finish (plant clock)."""
    came_before: Count = 0
    """More urgent goals that have come before it since it was taken."""


class PieceScrapped(Fact, told_by=MACHINES, frozen=True):
    """One cycle ended with a bad piece: its material is used up, and the piece is made again."""

    product: Id
    goal: IdOrNone = ""
    """Empty when the goal has ended meanwhile."""


class PieceMade(Fact, told_by=MACHINES, frozen=True):
    """One cycle ended well."""

    goal: Id
    product: Id
    made: Count
    """Pieces of this goal so far, this one included."""
    from_stock: bool = False
    """Whether spare pieces from stock serve this goal, without a cycle."""


class SparePieceMade(Fact, told_by=MACHINES, frozen=True):
    """One cycle ended well after its goal had ended: the piece serves the next goal."""

    product: Id
