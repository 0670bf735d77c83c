"""An operator's body is a person with a tablet: the calls shown and the person's answers."""

from __future__ import annotations

from enum import StrEnum

from dray.messages.base import Part
from dray.messages.people.call import CallAnswer, HelpCall
from dray.messages.problem import ProblemKind


class DutyState(Part, frozen=True):
    """The tablet's knowledge of the person on duty at it."""

    there: bool = True
    """Whether the tablet is connected; an operator without a connection leaves after a while."""
    on_break: bool = False
    busy_until_s: float | None = None
    """Time until which the person has declared to be busy (plant clock); None for not busy."""
    areas: tuple[str, ...] = ()
    everywhere: bool = False
    station: str = ""
    helps_with: tuple[ProblemKind, ...] = ()
    """Kinds of problems the person helps with; empty for everything."""
    label: str = ""
    """The person's displayed name; empty where names are not told."""


class DutyChanged(Part, frozen=True):
    """The state of the person or the tablet has changed."""

    state: DutyState


class CallReplied(Part, frozen=True):
    """The person answers a call, promises anew, or gives it back."""

    call: str
    answer: CallAnswer
    wait_s: float | None = None


class CallPart(StrEnum):
    """The operator's part in a call."""

    ASKED = "asked"
    TAKING = "taking"
    """Taken; the caller has not confirmed it yet."""
    TAKEN = "taken"
    """Confirmed: this operator is expected."""


class ShownCall(Part, frozen=True):
    """A call that concerns this operator."""

    call: HelpCall
    part: CallPart


class ShowCalls(Part, frozen=True):
    """All calls that concern this operator at this moment; a shown call that is missing here has ended."""

    calls: tuple[ShownCall, ...]


OperatorReport = DutyChanged | CallReplied
