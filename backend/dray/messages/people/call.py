"""Calls for help: whoever needs somebody asks those who are on duty (paper, case 4).

A call is a whole state, said again and again by the caller while it lasts: whom it asks, who has taken it, until when. So everybody
knows who comes, and a lost word costs time only. People are asked and never assigned: silence declines.
"""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated

from msgspec import Meta

from dray.messages.base import Count, Id, IdOrNone, Message, Metres, Seconds, Text
from dray.messages.kinds import BIDDERS, OPERATORS, STATIONS
from dray.messages.problem import NOTHING_KNOWN, Problem

ASKED_MAX = 32
"""Operators that one call asks at a time: more than are near to anything."""

CALL_WAIT_MAX_S = 900.0
"""The longest time that somebody who takes a call can promise; it may be promised anew."""


class CallState(StrEnum):
    """How far a call has come."""

    ASKING = "asking"
    """Some are asked, and have not answered yet."""
    RESTING = "resting"
    """Nobody is there to be asked, or nobody has taken it: asked again after a while."""
    TAKEN = "taken"
    """Somebody has promised to come."""
    ENDED = "ended"
    """Nobody is needed any more."""


class CallAnswer(StrEnum):
    """What an operator says to a call."""

    TAKE = "take"
    DECLINE = "decline"
    """Not now: others are asked."""
    CANNOT = "cannot"
    """Not at all: this operator is not asked again in this call."""


class HelpCall(Message, said_by=BIDDERS | STATIONS, signed="caller", radio=True, frozen=True):
    """A call as its caller tells it to everybody."""

    call: Id
    caller: Id
    incarnation: Count
    """Of the caller."""
    number: Count
    """Grows with each time that anything is said in one life of the caller: (incarnation, number) orders all words."""
    at_s: Seconds
    state: CallState
    since_s: Seconds
    problem: Problem = NOTHING_KNOWN
    reason: Text = ""
    """In words."""
    x_m: Metres = 0.0
    y_m: Metres = 0.0
    """Where help is needed."""
    round: Count = 1
    """How often it was asked; the reach grows with it."""
    asked: Annotated[tuple[Id, ...], Meta(max_length=ASKED_MAX)] = ()
    """Whose answer is awaited, the nearest first."""
    until_s: Seconds | None = None
    """By when they answer; when it was taken, by when it is promised; when it rests, when it is asked again."""
    taken_by: IdOrNone = ""
    turn: Count = 0
    """How often it was taken: of two who believe to have it the higher turn has."""
    on_duty: Count = 0
    """How many are on duty for that place, by what the caller has heard."""
    goods: IdOrNone = ""
    """The caller's transport whose goods wait on board of a failed vehicle; empty where the caller itself needs somebody."""

    @property
    def subject(self) -> tuple[str, str]:
        """What is called for: of two words about the same the newer counts."""
        return self.caller, self.goods


class CallAnswered(Message, said_by=OPERATORS, signed="operator", radio=True, frozen=True):
    """An operator's word on a call, to the caller."""

    call: Id
    operator: Id
    answer: CallAnswer
    wait_s: Seconds | None = None
    """With TAKE: within which time it will be done, `CALL_WAIT_MAX_S` at most."""
