"""Operators on duty, as agents: that they are there, where, and for which problems (paper, 3.2).

The name on the wire is that of the duty, and not of the person. A person's rights come only from the grant of each command, and from
nothing here.
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
"""Prefix of all operators' names on the bus. A gateway speaks for those who are on duty at its tablets."""


class DutyStatus(StrEnum):
    """Whether an operator on duty can be asked."""

    FREE = "free"
    BUSY = "busy"
    BREAK = "break"
    """There, but not to be asked."""


class OperatorHeartbeat(Message, said_by=OPERATORS, signed="operator", frozen=True):
    """The public state of an operator on duty, every few seconds and at once when it changes."""

    operator: Id
    incarnation: Count
    seq: Count
    at_s: Seconds
    status: DutyStatus
    areas: Annotated[tuple[Id, ...], Meta(max_length=MAX_AREAS)] = ()
    """The areas that the operator serves."""
    everywhere: bool = False
    """Whether the operator serves the whole plant."""
    station: IdOrNone = ""
    """The operator's working station; empty for none, or not published."""
    helps_with: Annotated[tuple[ProblemKind, ...], Meta(max_length=len(ProblemKind))] = ()
    """The kinds of problems that the operator helps with; empty for all."""
    caller: IdOrNone = ""
    """The caller that keeps the operator busy; empty for none."""
    until_s: Seconds | None = None
    """Until when, if known (plant clock)."""
    label: Text = ""
    """Name that is shown to people; empty when names are not published."""
    draining: bool = False
    """Whether this is the last heartbeat: the operator goes off duty."""
