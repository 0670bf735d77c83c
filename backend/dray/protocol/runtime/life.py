"""The effects and alarms of an agent and its parts in one step, in one handle."""

from __future__ import annotations

from collections.abc import Callable, Hashable

from dray.body import Instruction
from dray.messages import AnyFact, Message
from dray.protocol.runtime.events import (
    Effect,
    Ignore,
    Instruct,
    Publish,
    Record,
    Send,
    Subscribe,
    Unsubscribe,
)
from dray.protocol.runtime.timers import Timers, spread_frac

BEAT = "beat"
"""Alarm: the next heartbeat is due."""


class Change:
    """What has changed in a part of an agent; the agent alone reacts to it. Each kind is a small frozen value."""

    __slots__ = ()


class Life:
    """One life of an agent.

    Args:
        agent: its id.
        incarnation: how often the agent has been started, 1 for the first time.

    Attributes:
        beats: the number of its newest heartbeat.
        changes: in the agent's parts, to which it has not reacted yet, in order.
        effects: of this step, in order.
        react: the agent's reaction to a change, called with now_s; None if no agent lives this life.
        timers: the agent's alarms.
        unwritten: whether what the agent is bound by has changed in this step.
    """

    __slots__ = ("agent", "beats", "changes", "effects", "incarnation", "react", "timers", "unwritten")

    def __init__(self, agent: str = "", incarnation: int = 1) -> None:
        self.agent, self.incarnation = agent, incarnation
        self.beats = 0
        self.changes: list[Change] = []
        self.effects: list[Effect] = []
        self.react: Callable[[Change, float], None] | None = None
        self.timers = Timers()
        self.unwritten = False

    @property
    def mark(self) -> str:
        """Suffix of the names that the agent gives in this life, so that names differ between lives; empty in the first one."""
        return "" if self.incarnation == 1 else f".{self.incarnation}"

    def do(self, *effects: Effect) -> None:
        """Append effects to those of this step, in order; the methods below are shorter for single effects."""
        self.effects.extend(effects)

    def send(self, to: str, message: Message) -> None:
        """Send a message to one agent."""
        self.effects.append(Send(to, message))

    def publish(self, key: str, message: Message) -> None:
        """Publish a message on a bus key."""
        self.effects.append(Publish(key, message))

    def subscribe(self, key: str) -> None:
        """Subscribe to a bus key."""
        self.effects.append(Subscribe(key))

    def unsubscribe(self, key: str) -> None:
        """Unsubscribe from a bus key."""
        self.effects.append(Unsubscribe(key))

    def instruct(self, instruction: Instruction) -> None:
        """Instruct the body."""
        self.effects.append(Instruct(instruction))

    def record(self, fact: AnyFact) -> None:
        """Record a fact in the history."""
        self.effects.append(Record(fact))

    def ignore(self, reason: str) -> None:
        """Count an ignored message by its reason."""
        self.effects.append(Ignore(reason))

    def note(self, change: Change) -> None:
        """Note a change in a part; the agent reacts to it when the part has done its work."""
        self.changes.append(change)

    def settle(self, now_s: float) -> None:
        """Have the agent react to all changes so far, in order.

        The agent does this after each event and each alarm. A part does it where its next act must follow the
        reaction.
        """
        while self.changes and self.react is not None:
            self.react(self.changes.pop(0), now_s)

    def commit(self) -> None:
        """Have what the agent is bound by stored before this step's other effects.

        It may be called after every change; the state at the end of the step is stored.
        """
        self.unwritten = True

    def beat_soon(self, now_s: float) -> None:
        """Send a heartbeat at the end of this step, because it tells something new."""
        self.timers.set(BEAT, now_s)

    def count_beat(self) -> int:
        """Count a heartbeat, and return its number."""
        self.beats += 1
        return self.beats

    def beat_again(self, interval_s: float, now_s: float) -> None:
        """Set the alarm of the next heartbeat; the first interval is shortened by a fraction from the agent's name."""
        if self.beats == 1:
            interval_s *= 0.5 + spread_frac(self.agent) / 2
        self.alarm(BEAT, now_s + interval_s)

    def alarm(self, name: Hashable, at_s: float) -> None:
        """Sound `name` at `at_s`; an alarm that is already set is moved."""
        self.timers.set(name, at_s)

    def cancel(self, name: Hashable) -> None:
        """Cancel the alarm `name`; ignored if it is not set."""
        self.timers.clear(name)

    def awaits(self, name: Hashable) -> bool:
        """Whether an alarm is set."""
        return self.timers.is_set(name)
