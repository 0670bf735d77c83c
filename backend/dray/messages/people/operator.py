"""Operators on duty, as agents: who is there, where, and what for (paper, 3.2).

The name on the wire is one of the duty and of nobody's: it says that somebody is there, and not who. What a person may do is
told by the grant of each command, and by nothing here.
"""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated

from msgspec import Meta

from dray.messages.base import Count, Id, IdOrNone, Message, Seconds, Text
from dray.messages.kinds import OPERATORS
from dray.messages.people.command import MAX_AREAS
from dray.messages.problem import ProblemKind

OPERATOR_PREFIX = "operator."
"""Begins the names of all operators on the bus. A gateway speaks for those who are on duty at its tablets."""


class DutyStatus(StrEnum):
    """Whether somebody who is there can be asked."""

    FREE = "free"
    BUSY = "busy"
    BREAK = "break"
    """There, and not to be asked."""


class OperatorHeartbeat(Message, said_by=OPERATORS, signed="operator", frozen=True):
    """What an operator on duty tells everybody: a whole state, every few seconds and at once when it changes."""

    operator: Id
    incarnation: Count
    seq: Count
    at_s: Seconds
    status: DutyStatus
    areas: Annotated[tuple[Id, ...], Meta(max_length=MAX_AREAS)] = ()
    """For which areas the operator is there."""
    everywhere: bool = False
    """For all of the plant."""
    station: IdOrNone = ""
    """At which working station; empty for none, or not told."""
    helps_with: Annotated[tuple[ProblemKind, ...], Meta(max_length=len(ProblemKind))] = ()
    """What for; empty for everything."""
    caller: IdOrNone = ""
    """With whom the operator is busy; empty for nobody who has called."""
    until_s: Seconds | None = None
    """Until when, as far as that is known (plant clock)."""
    label: Text = ""
    """What people are shown; empty where names are not told."""
    draining: bool = False
    """The last one: off duty."""
