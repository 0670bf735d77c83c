"""News: failures and what became of them, as people should hear of them without looking.

A takeover is told twice, by the vehicle and by the coordinator; it is one piece of news, named by its
task and epoch, in which the coordinator's word counts for more. Of a vehicle's link, of its wish for
help and of an order that waits only the newest is kept, so that a vehicle at the edge of the WLAN does
not push the rest out.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from dray.gateway.live.projection.changes import Changes
from dray.gateway.live.reasons import detail_of, failures_of
from dray.gateway.live.views import NewsView
from dray.messages import Event, Link, Reason
from dray.messages.fact import (
    CarrierChanged,
    ContractEnded,
    GoalLost,
    GoalWaits,
    HelpAsked,
    HelpPromised,
    LinkChanged,
    MemoryLost,
    TookOver,
)
from dray.store.history.clocks import ToWall

NEWS_KEPT = 50
"""What a person can still read; all facts are in the events."""


class News:
    """What has happened lately.

    Args:
        to_wall_s: plant clock to wall clock.
    """

    def __init__(self, to_wall_s: ToWall) -> None:
        self._to_wall_s = to_wall_s
        self._news: dict[str, NewsView] = {}
        """By name."""
        self._on: dict[type, Callable[[Event, Any], bool]] = {
            TookOver: self._took_over,
            CarrierChanged: self._carrier_changed,
            ContractEnded: self._contract_ended,
            LinkChanged: self._link_changed,
            HelpAsked: self._help_asked,
            HelpPromised: self._help_promised,
            GoalLost: self._goal_lost,
            GoalWaits: self._goal_waits,
            MemoryLost: self._memory_lost,
        }
        self.heeded = tuple(self._on)
        """Kinds of facts that are news."""
        self.changes = Changes("news")

    def fold(self, event: Event) -> bool:
        """Take an event in.

        Returns:
            False when it is no news.
        """
        handler = self._on.get(type(event.fact))
        return handler is not None and handler(event, event.fact)

    def views(self) -> tuple[NewsView, ...]:
        """All that is kept, oldest first; what has come late stands at its time."""
        return tuple(sorted(self._news.values(), key=lambda news: news.at_s))

    def take_changed(self) -> tuple[NewsView, ...]:
        """What has changed since the last call."""
        return tuple(self._news[name] for name in self.changes.take_changed())

    # --- carriers ---

    def _took_over(self, event: Event, fact: TookOver) -> bool:
        name = _takeover(fact.task, fact.epoch)
        if name in self._news:
            return False
        news = self._new(name, "took_over", event, fact.reason)
        news.other, news.task, news.epoch, news.silent_s = fact.primary, fact.task, fact.epoch, fact.silent_s
        news.confirmed = False
        return self._tell(news)

    def _carrier_changed(self, event: Event, fact: CarrierChanged) -> bool:
        name = _takeover(fact.task, fact.epoch)
        known = self._news.get(name)
        if known is not None and known.confirmed:
            return False
        if known is not None and known.agent == fact.carrier:
            known.confirmed = True
            self.changes.mark(name)
            return True
        news = self._new(name, "took_over" if fact.carrier else "announced_anew", event, fact.reason)
        news.agent = fact.carrier or event.agent
        news.other, news.task, news.epoch, news.silent_s = fact.replaced, fact.task, fact.epoch, fact.silent_s
        return self._tell(news)

    def _contract_ended(self, event: Event, fact: ContractEnded) -> bool:
        """The coordinator still hears the one that was to be replaced."""
        known = self._news.get(_takeover(fact.task, fact.epoch))
        if (
            known is None
            or known.confirmed
            or known.agent != event.agent
            or fact.reason == Reason.HANDED_OVER
        ):
            return False
        known.kind, known.reason, known.confirmed = "takeover_refused", fact.reason, True
        self.changes.mark(known.id)
        return True

    # --- vehicles ---

    def _link_changed(self, event: Event, fact: LinkChanged) -> bool:
        kind = "link_lost" if fact.link is Link.MESH else "link_back"
        return self._tell(self._new(f"link-{event.agent}", kind, event))

    def _help_asked(self, event: Event, fact: HelpAsked) -> bool:
        news = self._new(f"help-{event.agent}", "help_asked", event)
        news.cause = detail_of(fact.reason)
        news.task, news.until_at_s = fact.task, self._to_wall_s(fact.until_s)
        return self._tell(news)

    def _help_promised(self, event: Event, fact: HelpPromised) -> bool:
        news = self._new(f"help-{event.agent}", "help_promised", event)
        news.other, news.until_at_s = fact.promised_by, self._to_wall_s(fact.until_s)
        return self._tell(news)

    # --- goals ---

    def _goal_lost(self, event: Event, fact: GoalLost) -> bool:
        news = self._new(f"lost-{fact.goal}", "goal_lost", event)
        news.agent, news.goal = fact.machine, fact.goal
        news.arrived, news.successor = fact.arrived, fact.successor
        return self._tell(news)

    def _goal_waits(self, event: Event, fact: GoalWaits) -> bool:
        news = self._new(f"waits-{fact.order}", "goal_waits", event)
        news.cause = failures_of(fact)
        news.goal, news.order = fact.goal, fact.order
        return self._tell(news)

    # --- agents ---

    def _memory_lost(self, event: Event, fact: MemoryLost) -> bool:
        news = self._new(f"memory-{event.agent}", "memory_lost", event)
        news.cause = detail_of(fact.reason)
        return self._tell(news)

    def _new(self, name: str, kind: Any, event: Event, reason: str = "") -> NewsView:
        return NewsView(
            id=name, kind=kind, at_s=self._to_wall_s(event.at_s), agent=event.agent, reason=reason
        )

    def _tell(self, news: NewsView) -> bool:
        known = self._news.get(news.id)
        if known is not None and known.at_s >= news.at_s:
            return False  # it came again, or late
        # What is told anew is the newest again.
        self._news.pop(news.id, None)
        self._news[news.id] = news
        self.changes.mark(news.id)
        if len(self._news) > NEWS_KEPT:
            oldest = min(self._news, key=lambda name: self._news[name].at_s)
            del self._news[oldest]
            self.changes.drop(oldest)
        return True


def _takeover(task: str, epoch: int) -> str:
    return f"{task}@{epoch}"
