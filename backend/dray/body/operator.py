"""An operator's body is a person with a tablet: what they are shown and what they say."""

from __future__ import annotations

from enum import StrEnum

from dray.messages.base import Part
from dray.messages.people.call import CallAnswer, HelpCall
from dray.messages.problem import ProblemKind


class DutyState(Part, frozen=True):
    """What a tablet knows of the person who is on duty at it."""

    there: bool = True
    """The tablet is connected; an operator whose tablet is not leaves after a while."""
    on_break: bool = False
    busy_until_s: float | None = None
    """Busy by the person's own word until then (plant clock); None for not."""
    areas: tuple[str, ...] = ()
    everywhere: bool = False
    station: str = ""
    helps_with: tuple[ProblemKind, ...] = ()
    """Empty for everything."""
    label: str = ""
    """What others are shown of the person; empty where names are not told."""


class DutyChanged(Part, frozen=True):
    """The person or the tablet is otherwise than before."""

    state: DutyState


class CallReplied(Part, frozen=True):
    """The person answers a call, promises anew, or gives it back."""

    call: str
    answer: CallAnswer
    wait_s: float | None = None


class CallPart(StrEnum):
    """What the operator has to do with a call."""

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
    """All calls that concern this operator at this moment; what was shown before and is not here is over."""

    calls: tuple[ShownCall, ...]


OperatorReport = DutyChanged | CallReplied
