"""An agent's history: numbered events, each with a fact, and how missed ones are asked for again.

An agent numbers its facts from 1 in every incarnation and publishes each as an `Event`. The historian keeps them in SQL;
panels and reports are computed from them.
"""

from __future__ import annotations

from dray.messages.base import Count, Id, Message, Seconds
from dray.messages.fact import AnyFact
from dray.messages.kinds import GATEWAYS, HISTORIANS, TELLERS

EVENTS_PER_ANSWER = 200
"""Maximum events in one answer to `EventsAsked`."""

HISTORY_KEPT = 10_000
"""Events of its history that an agent keeps, some 5 MB on the disk. A strategist whose machines come and go records a thousand facts
in minutes; events that it drops before the historian is back are lost for good."""


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


class Event(Message, said_by=TELLERS, signed="agent", frozen=True):
    """One numbered line of an agent's history."""

    agent: Id
    incarnation: Count
    number: Count
    """1, 2, 3 ... in one incarnation, without a gap."""
    at_s: Seconds
    fact: AnyFact
