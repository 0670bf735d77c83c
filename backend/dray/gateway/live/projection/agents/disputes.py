"""Disputes: what coordinators do not believe of vehicles and machines, while it is worth a look."""

from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar

import msgspec

from dray.gateway.live.reasons import ANOTHERS_KEY, ROBS_PLACES, told
from dray.gateway.live.views import CauseView, HandoverView
from dray.messages import Event
from dray.messages.fact import BookRefused, HandoverDisputed, NameMisused, WordDisbelieved
from dray.protocol.contract_net.trust.reliability import HALF_LIFE_S

AGENTS_KEPT = 1_000
"""Maximum agents per kind of dispute: more than people could look at."""


class Dispute(msgspec.Struct):
    """The latest dispute about one agent."""

    agent: str
    by: str
    """The last agent to report it."""
    cause: CauseView
    """The disputed statement, and how often it was reported."""
    at_s: float
    task: str = ""


class Disputes:
    """The disputes of the last half hour, by agent."""

    heeded: ClassVar[tuple[type, ...]] = (HandoverDisputed, WordDisbelieved, NameMisused, BookRefused)
    """Kinds of facts that dispute an agent's word."""

    def __init__(self) -> None:
        self._handovers: dict[str, Dispute] = {}
        self._words: dict[str, Dispute] = {}

    def fold(self, event: Event) -> bool:
        """Take an event in; False when it is about something else."""
        match event.fact:
            case HandoverDisputed() as fact:
                load = HandoverView(fact.said, fact.item, fact.where, fact.counted)
                cause = CauseView(handover=load)
                _put(
                    self._handovers,
                    Dispute(fact.contractor, event.agent, cause, event.at_s, task=fact.task),
                )
            case WordDisbelieved() as fact:
                cause = CauseView(reason=fact.reason.value, clock_ahead_s=fact.clock_ahead_s)
                _put(self._words, Dispute(fact.contractor, event.agent, cause, event.at_s, task=fact.task))
            case NameMisused() as fact:
                _put(
                    self._words,
                    Dispute(fact.atv, event.agent, CauseView(reason=ANOTHERS_KEY), event.at_s),
                )
            case BookRefused() as fact:
                cause = CauseView(reason=ROBS_PLACES)
                _put(self._words, Dispute(fact.keeper, event.agent, cause, event.at_s))
            case _:
                return False
        return True

    def handovers(self, now_s: float) -> Iterator[Dispute]:
        """Vehicles whose handovers were not counted."""
        return _lately(self._handovers, now_s)

    def words(self, now_s: float) -> Iterator[Dispute]:
        """Agents that made impossible statements."""
        return _lately(self._words, now_s)


def _put(known: dict[str, Dispute], dispute: Dispute) -> None:
    before = known.pop(dispute.agent, None)
    if before is not None:
        dispute.cause.times = before.cause.times + 1
    told(dispute.cause)
    known[dispute.agent] = dispute
    if len(known) > AGENTS_KEPT:
        del known[next(iter(known))]


def _lately(known: dict[str, Dispute], now_s: float) -> Iterator[Dispute]:
    for agent in [each.agent for each in known.values() if now_s - each.at_s > HALF_LIFE_S]:
        del known[agent]
    return iter(tuple(known.values()))
