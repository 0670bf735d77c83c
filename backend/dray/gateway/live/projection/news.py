"""News: failures and their outcomes, for people who are not watching.

The vehicle and the coordinator both report a takeover; it is one piece of news, named by task and epoch, and
the coordinator's word overrides. Only the newest news is kept of a vehicle's link, its call for help, and an
order that waits. So a vehicle at the edge of the WLAN does not push out the rest.

No fact reports silence, removals, Stop and closures: `look` compares the present state with the one before.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping
from typing import Any, NamedTuple

from msgspec.structs import replace

from dray.gateway.live.projection.changes import Changes
from dray.gateway.live.reasons import detail_of, failures_of
from dray.gateway.live.views import ClosureView, CommandView, NewsView, RemovalView
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
"""Maximum news kept, as many as a person can read; the events have all facts."""


class Present(NamedTuple):
    """The state at one moment, as far as it makes news.

    Attributes:
        wall_s: the moment.
        last_s: when each agent that is neither shut out nor carried away was heard last (plant clock).
        silent: those of them that have been silent for longer than allowed.
        removals: vehicles that people have carried away.
        closures: closures in force.
        commands: recent commands to vehicles.
    """

    wall_s: float
    last_s: Mapping[str, float]
    silent: frozenset[str]
    removals: Mapping[str, RemovalView]
    closures: Iterable[ClosureView]
    commands: Iterable[CommandView]


class News:
    """What has happened lately.

    Args:
        to_wall_s: plant clock to wall clock.
    """

    def __init__(self, to_wall_s: ToWall) -> None:
        self._to_wall_s = to_wall_s
        self._news: dict[str, NewsView] = {}
        """By name."""
        self._silent_since_s: dict[str, float] = {}
        """Silent agents -> when they were heard last (plant clock)."""
        self._away: frozenset[str] = frozenset()
        self._closed: dict[str, ClosureView] = {}
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

    def look(self, now: Present) -> None:
        """Report what has begun and ended since the last look."""
        self._look_for_silence(now)
        self._look_for_removals(now)
        self._look_for_closures(now)
        self._look_for_stops(now.commands)

    def views(self) -> tuple[NewsView, ...]:
        """All news kept, in order of time, oldest first."""
        return tuple(sorted(self._news.values(), key=lambda news: news.at_s))

    def take_changed(self) -> tuple[NewsView, ...]:
        """News that changed since the last call."""
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
        """The coordinator refused a takeover, since it still hears the replaced carrier."""
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

    # --- what is compared ---

    def _look_for_silence(self, now: Present) -> None:
        begun = sorted(now.silent - self._silent_since_s.keys())
        heard = sorted(
            agent for agent in self._silent_since_s if agent in now.last_s and agent not in now.silent
        )
        if begun:
            self._say(f"silence-{begun[0]}", "silent", now.wall_s, begun[0], agents=_several(begun))
        if heard:
            silent_s = max(now.last_s[agent] - self._silent_since_s[agent] for agent in heard)
            agents = _several(heard)
            self._say(
                f"silence-{heard[0]}", "heard_again", now.wall_s, heard[0], agents=agents, silent_s=silent_s
            )
        before = self._silent_since_s
        self._silent_since_s = {agent: before.get(agent, now.last_s[agent]) for agent in now.silent}

    def _look_for_removals(self, now: Present) -> None:
        away = frozenset(now.removals)
        for atv in away - self._away:
            removal = now.removals[atv]
            self._say(f"removal-{atv}", "carried_away", removal.at_s, atv, other=removal.by)
        for atv in (self._away - away) & now.last_s.keys():
            self._say(f"back-{atv}", "put_back", now.wall_s, atv)
        self._away = away

    def _look_for_closures(self, now: Present) -> None:
        closed = {view.id: replace(view, lanes=(), not_known_by=(), cut_off=()) for view in now.closures}
        for name in closed.keys() - self._closed.keys():
            view = closed[name]
            self._say(f"closure-{name}", "closed", view.at_s, "", other=view.by, closure=view)
        for name in self._closed.keys() - closed.keys():
            self._say(f"opened-{name}", "opened", now.wall_s, "", closure=self._closed[name])
        self._closed = closed

    def _look_for_stops(self, commands: Iterable[CommandView]) -> None:
        """Report stops; one person's stop of all vehicles in an area is one piece of news."""
        stops: dict[tuple[str, int], list[CommandView]] = defaultdict(list)
        for command in commands:
            if command.kind == "stop":
                stops[command.by, int(command.at_s)].append(command)
        for (by, second), given in stops.items():
            name, agents = f"stop-{by}-{second}", _several(sorted({each.atv for each in given}))
            known = self._news.get(name)
            if known is None:
                self._say(name, "stopped", given[0].at_s, given[0].atv, other=by, agents=agents)
            elif known.agents != agents:
                known.agents = agents
                self.changes.mark(name)

    def _say(self, name: str, kind: Any, at_s: float, agent: str, **more: Any) -> None:
        self._tell(NewsView(id=name, kind=kind, at_s=at_s, agent=agent, **more))

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
            return False  # a duplicate, or late
        # Repeated news becomes the newest again.
        self._news.pop(news.id, None)
        self._news[news.id] = news
        self.changes.mark(news.id)
        if len(self._news) > NEWS_KEPT:
            oldest = min(self._news, key=lambda name: self._news[name].at_s)
            del self._news[oldest]
            self.changes.drop(oldest)
        return True


def _several(agents: Iterable[str]) -> tuple[str, ...]:
    """All names; none for a single agent, which is named already."""
    names = tuple(agents)
    return names if len(names) > 1 else ()


def _takeover(task: str, epoch: int) -> str:
    return f"{task}@{epoch}"
