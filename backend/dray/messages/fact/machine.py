"""What a machine tells: how it is, and what it has made."""

from __future__ import annotations

from dray.messages.base import Count, Id, IdOrNone, Text
from dray.messages.fact.base import Fact
from dray.messages.heartbeat import MachineStatus
from dray.messages.kinds import MACHINES


class MachineStatusChanged(Fact, told_by=MACHINES, frozen=True):
    """The machine began, starved, was blocked, broke or stopped."""

    status: MachineStatus
    product: IdOrNone = ""
    reason: Text = ""


class PieceScrapped(Fact, told_by=MACHINES, frozen=True):
    """One cycle ended with a bad piece: what it has used is used, and the piece is made again."""

    product: Id
    goal: IdOrNone = ""
    """Empty where the goal has ended meanwhile."""


class PieceMade(Fact, told_by=MACHINES, frozen=True):
    """One cycle ended well."""

    goal: Id
    product: Id
    made: Count
    """Of this goal, with this one."""
    from_stock: bool = False
    """No cycle has ended: pieces that lay there serve this goal."""


class SparePieceMade(Fact, told_by=MACHINES, frozen=True):
    """One cycle ended well, and its goal had ended before: the piece serves the next one."""

    product: Id
