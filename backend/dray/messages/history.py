"""An agent's history: numbered events, each with a fact, and how missed ones are asked for again.

An agent numbers its facts from 1 in every incarnation and publishes each as an `Event`. The historian keeps them in SQL;
panels and reports are computed from them.
"""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta

from dray.messages.base import Count, Id, Message, Part, Seconds
from dray.messages.fact import AnyFact
from dray.messages.kinds import GATEWAYS, HISTORIANS, TELLERS

EVENTS_PER_ANSWER = 200
"""Maximum events in one answer to `EventsAsked`."""

HISTORY_KEPT = 10_000
"""Events of its history that an agent keeps, some 5 MB on the disk. A strategist whose machines come and go records a thousand facts
in minutes; events that it drops before the historian is back are lost for good."""

LIVES_TOLD = 32
"""Maximum earlier lives in one answer, the newest: more than an agent begins while nobody listens, unless it restarts every few seconds
for long."""


class LifeKept(Part, frozen=True):
    """The events of one ended life that an agent still has: all from `first` to `last`, at least one."""

    incarnation: Count
    first: Count
    last: Count


class EventsAsked(Message, said_by=GATEWAYS | HISTORIANS, frozen=True):
    """Ask an agent for missed events.

    The agent answers the asker alone: with the `Event`s that it still has, at most `EVENTS_PER_ANSWER`, and then with `EventsKept`.
    A question beyond the end of the history shows its newest number.
    """

    incarnation: Count
    first: Count
    last: Count
    """Both included."""


class EventsKept(Message, said_by=TELLERS, frozen=True):
    """The events of one life that an agent still has: all from `first` to `last`.

    Events before `first` are lost for good. None are kept when `last` is below `first`.
    """

    incarnation: Count
    """The life that was asked about."""
    first: Count
    last: Count
    life: Count
    """The agent's present life: earlier ones get no more events."""
    earlier: Annotated[tuple[LifeKept, ...], Meta(max_length=LIVES_TOLD)] | None = None
    """The newest lives before the present one with kept events, oldest first. So a listener learns of lives that it missed
    altogether. None from an agent that does not say; such an agent is asked about each life."""


class Event(Message, said_by=TELLERS, signed="agent", frozen=True):
    """One numbered line of an agent's history."""

    agent: Id
    incarnation: Count
    number: Count
    """1, 2, 3 ... in one incarnation, without a gap."""
    at_s: Seconds
    fact: AnyFact
