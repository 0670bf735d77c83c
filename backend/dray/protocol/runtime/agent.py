"""The common base of all agents: one step at a time, from an event to effects."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from dray.body import BodyState, Report
from dray.errors import ProtocolViolation
from dray.memory import Memory, Note
from dray.messages import Message
from dray.messages.fact import MemoryLost
from dray.protocol.runtime.events import (
    NOT_FOR_US,
    Commit,
    Effect,
    Event,
    Leave,
    Leaving,
    Received,
    Reported,
    Woke,
)
from dray.protocol.runtime.life import Change, Life
from dray.protocol.runtime.shutdown import GracefulShutdown

Handler = Callable[[str, Any, float], None]
"""Called with (sender, message, now_s)."""

Reaction = Callable[[Any, float], None]
"""Called with a change and now_s."""

Alarm = Callable[[Any, float], None]
"""Called with the second part of the alarm's name, or None, and now_s."""


DEAF_S = 0.5
"""Minimum lateness of an alarm that shows that the agent's own process was held up (s). Failure detection allows for less
(`liveness.suspicion.JITTER_S`)."""


class AgentBase:
    """The base of an agent: implements `dray.protocol.runtime.events.Agent`.

    The subclass fills four tables: the handlers of messages, of its body's reports, of alarms, and of changes in its
    parts (`Life.note`). An alarm's name is a word, or a word and its subject: ``"beat"``, ``("watched silence", task)``.

    Args:
        agent: its name on the bus.
        incarnation: how often it has been started, 1 for the first time.
        leaves_within_s: maximum time from the request to leave until it leaves.
    """

    def __init__(self, agent: str, incarnation: int, *, leaves_within_s: float) -> None:
        self.id = agent
        self.incarnation = incarnation
        self._life = Life(agent, incarnation)
        self._life.react = self._react
        self._shutdown = GracefulShutdown(leaves_within_s)
        self._last_word = Leave()
        self._message_handlers: dict[type[Message], Handler] = {}
        self._report_handlers: Mapping[type[Report], Callable[[Any, float], None]] = {}
        self._alarm_handlers: Mapping[str, Alarm] = {}
        self._reactions: Mapping[type[Change], Reaction] = {}
        self._committers: list[Callable[[], Sequence[Commit]]] = [self._own_commit]
        """Each returns what to store at the end of a step."""

    @property
    def wake_at_s(self) -> float:
        alarm_s, leave_s = self._life.timers.next_s, self._shutdown.latest_s
        return alarm_s if alarm_s < leave_s else leave_s  # noqa: FURB136 (a call of min costs more than the rest)

    def handle(self, event: Event, now_s: float) -> list[Effect]:
        """Take one step; see `dray.protocol.runtime.events.Agent`."""
        if isinstance(event, Woke):  # The most frequent first.
            if event.late_s > DEAF_S:
                self._was_deaf(event.late_s)
            self._sense(event.body, now_s)
            self._life.settle(now_s)
            self._sound_alarms(now_s)
        elif isinstance(event, Received):
            if event.body is not None:
                self._sense(event.body, now_s)
                self._life.settle(now_s)
            self._on_message(event, now_s)
        elif isinstance(event, Reported):
            self._on_report(event.report, now_s)
        elif isinstance(event, Leaving):
            self._on_leaving(now_s)
        else:
            if event.lost:
                self._life.record(MemoryLost(reason=event.lost))
            self._start(event.body, event.memory, now_s)
        self._life.settle(now_s)
        if self._shutdown.lasts:
            self._leave_if_free(now_s)
        effects: list[Effect] = []
        for commits in self._committers:
            effects += commits()
        effects += self._life.effects
        self._life.effects.clear()
        return effects

    def _own_commit(self) -> Sequence[Commit]:
        if not self._life.unwritten:
            return ()
        self._life.unwritten = False
        return (Commit(self._memory()),)

    def _memory(self) -> Note:
        """What the agent is bound by now, if that is one note."""
        raise NotImplementedError

    def _start(self, body: BodyState | None, memory: Memory, now_s: float) -> None:
        """Begin the agent's life from what its last one has committed."""
        raise NotImplementedError

    def _sense(self, body: BodyState | None, now_s: float) -> None:
        """Note what the body senses, before anything else is done."""

    def _was_deaf(self, span_s: float) -> None:
        """The agent's own process was held up for this long: other agents' silence in that time does not count."""

    def _prepare_to_leave(self, now_s: float) -> None:
        """The agent was asked to leave: give back what others can do."""

    def _is_held(self) -> bool:
        """Whether the agent must stay: it has work that only it can finish, or awaits an answer."""
        return False

    def _take_leave(self, now_s: float) -> None:
        """Send the last heartbeat of this life."""

    def _on_message(self, received: Received, now_s: float) -> None:
        handle = self._message_handlers.get(type(received.message))
        if handle is None:
            self._life.ignore(NOT_FOR_US)
        elif objection := self._objection(received.sender, received.message):
            self._life.ignore(objection)
        else:
            handle(received.sender, received.message, now_s)

    def _objection(self, sender: str, message: Message) -> str:
        """Why a message is ignored without further checks; empty if it is handled."""
        return ""

    def _react(self, change: Change, now_s: float) -> None:
        reaction = self._reactions.get(type(change))
        if reaction is None:
            raise ProtocolViolation(f"{self.id} does not react to {change}")
        reaction(change, now_s)

    def _on_report(self, report: Report, now_s: float) -> None:
        handle = self._report_handlers.get(type(report))
        if handle is None:
            raise ProtocolViolation(f"{self.id} has no body that could report {report}")
        handle(report, now_s)

    def _on_leaving(self, now_s: float) -> None:
        if not self._shutdown.begun:
            self._shutdown.start_draining(now_s)
            self._prepare_to_leave(now_s)

    def _leave_if_free(self, now_s: float) -> None:
        if now_s < self._shutdown.latest_s and self._is_held():
            return
        self._shutdown.complete()
        self._take_leave(now_s)
        self._life.do(self._last_word)

    def _sound_alarms(self, now_s: float) -> None:
        for name in self._life.timers.due(now_s):
            kind, about = name if isinstance(name, tuple) else (name, None)
            self._alarm_handlers[kind](about, now_s)
            self._life.settle(now_s)
