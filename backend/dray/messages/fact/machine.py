"""What a machine tells: how it is, and what it has made."""

from __future__ import annotations

from dray.messages.base import Count, Id, IdOrNone, Text
from dray.messages.fact.base import Fact
from dray.messages.heartbeat import MachineStatus


class MachineStatusChanged(Fact, frozen=True):
    """The machine began, starved, was blocked, broke or stopped."""

    status: MachineStatus
    product: IdOrNone = ""
    reason: Text = ""


class PieceMade(Fact, frozen=True):
    """One cycle ended well."""

    goal: Id
    product: Id
    made: Count
    """Of this goal, with this one."""
