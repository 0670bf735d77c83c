"""Calls for help: an agent asks the operators on duty (paper, case 4).

A call is a whole state, which the caller repeats while it lasts: the operators asked, the one who has taken it, and until when. So
all agents know who comes, and a lost message only costs time. Operators are asked and never assigned: silence declines.
"""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated

from msgspec import Meta

from dray.messages.base import Count, Id, IdOrNone, Message, Metres, Seconds, Text
from dray.messages.kinds import BIDDERS, OPERATORS, STATIONS
from dray.messages.problem import NOTHING_KNOWN, Problem

ASKED_MAX = 32
"""Maximum operators that one call asks at a time: more than are ever nearby."""

CALL_WAIT_MAX_S = 900.0
"""Longest time that an operator who takes a call can promise; it may be promised anew."""


class CallState(StrEnum):
    """The state of a call."""

    ASKING = "asking"
    """Operators were asked, and have not all answered yet."""
    RESTING = "resting"
    """No operator is there, or none has taken it: the caller asks again after a while."""
    TAKEN = "taken"
    """An operator has promised to come."""
    ENDED = "ended"
    """No help is needed any more."""


class CallAnswer(StrEnum):
    """An operator's answer to a call."""

    TAKE = "take"
    DECLINE = "decline"
    """Not now: others are asked."""
    CANNOT = "cannot"
    """Not at all: this call does not ask the operator again."""


class CallPlace(StrEnum):
    """How well a caller knows the place that it names."""

    PRESENT = "present"
    LAST = "last"
    """The caller was there when it last knew; it may have been moved since."""
    UNTOLD = "untold"
    """The caller has never known: the position is its start in the plant file, if it has one there."""


class HelpCall(Message, said_by=BIDDERS | STATIONS, signed="caller", radio=True, frozen=True):
    """The state of a call, which its caller publishes."""

    call: Id
    caller: Id
    incarnation: Count
    """The caller's incarnation."""
    number: Count
    """Grows with each message in one life of the caller: (incarnation, number) orders all of them."""
    at_s: Seconds
    state: CallState
    since_s: Seconds
    problem: Problem = NOTHING_KNOWN
    reason: Text = ""
    """The problem in words."""
    x_m: Metres = 0.0
    y_m: Metres = 0.0
    """The position where help is needed."""
    place: CallPlace = CallPlace.PRESENT
    """How well the caller knows that position."""
    round: Count = 1
    """Number of this round of questions; each reaches farther."""
    asked: Annotated[tuple[Id, ...], Meta(max_length=ASKED_MAX)] = ()
    """The operators whose answers are awaited, the nearest first."""
    until_s: Seconds | None = None
    """Deadline for answers; when taken, the promised time; when resting, the time of the next round."""
    taken_by: IdOrNone = ""
    turn: Count = 0
    """How often it was taken; if two operators believe to have taken it, the one with the higher turn has."""
    on_duty: Count = 0
    """Number of operators on duty for that place, as far as the caller knows."""
    goods: IdOrNone = ""
    """The caller's transport whose goods wait on board of a failed vehicle; empty when the caller itself needs help."""

    @property
    def subject(self) -> tuple[str, str]:
        """The subject of the call: of two messages about the same one, the newer counts."""
        return self.caller, self.goods


class CallAnswered(Message, said_by=OPERATORS, signed="operator", radio=True, frozen=True):
    """An operator's answer to a call, to the caller."""

    call: Id
    operator: Id
    answer: CallAnswer
    wait_s: Seconds | None = None
    """With TAKE: the time until it will be done, `CALL_WAIT_MAX_S` at most."""
