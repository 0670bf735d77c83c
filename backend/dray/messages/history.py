"""An agent's history: numbered events, each with a fact, and how those that were missed are asked for again.

An agent numbers its facts from 1 in every incarnation and publishes each as an `Event`. The historian keeps them in SQL;
panels and reports are computed from them.
"""

from __future__ import annotations

from dray.messages.base import Count, Id, Message, Seconds
from dray.messages.fact import AnyFact
from dray.messages.kinds import GATEWAYS, HISTORIANS, TELLERS

EVENTS_PER_ANSWER = 200
"""Events that one answer to `EventsAsked` holds at most."""

HISTORY_KEPT = 10_000
"""Events that an agent keeps of its history, some 5 MB on the disk: nobody asks for older ones. A strategist whose machines
come and go tells a thousand facts in minutes, and what it forgets before the historian is back is gone for good."""


class EventsAsked(Message, said_by=GATEWAYS | HISTORIANS, frozen=True):
    """Tell again what was missed.

    Answered to the asker alone, with those `Event`s that the agent still has, `EVENTS_PER_ANSWER` at most,
    and then with `EventsKept`. Asking for more than there is shows what was said last.
    """

    incarnation: Count
    first: Count
    last: Count
    """Both included."""


class EventsKept(Message, said_by=TELLERS, frozen=True):
    """Which numbers of one of its lives an agent can still tell: all from `first` to `last`.

    What is asked for and lies before `first` is gone for good. None are kept when `last` is below `first`.
    """

    incarnation: Count
    """The life that was asked about."""
    first: Count
    last: Count
    life: Count
    """The one that answers: of those before it there will be no more."""


class Event(Message, said_by=TELLERS, signed="agent", frozen=True):
    """One numbered line of an agent's history."""

    agent: Id
    incarnation: Count
    number: Count
    """1, 2, 3 ... in one incarnation, without a gap."""
    at_s: Seconds
    fact: AnyFact
