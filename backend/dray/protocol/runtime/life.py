"""What an agent and its parts do in one step, and when they are to be woken: one handle for all of them."""

from __future__ import annotations

from collections.abc import Hashable

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


class Life:
    """One life of an agent.

    Args:
        agent: whose.

    Attributes:
        beats: the number of its newest heartbeat.
        effects: of this step, in their order.
        timers: the agent's alarms.
        unwritten: what the agent is bound by has changed in this step.
    """

    __slots__ = ("_agent", "beats", "effects", "timers", "unwritten")

    def __init__(self, agent: str = "") -> None:
        self._agent = agent
        self.beats = 0
        self.effects: list[Effect] = []
        self.timers = Timers()
        self.unwritten = False

    def do(self, *effects: Effect) -> None:
        """Have these done, in their order, after those of this step so far; what is made elsewhere, or is no one-liner below."""
        self.effects.extend(effects)

    def send(self, to: str, message: Message) -> None:
        """Say something to one agent."""
        self.effects.append(Send(to, message))

    def publish(self, key: str, message: Message) -> None:
        """Say something to all who listen to a bus key."""
        self.effects.append(Publish(key, message))

    def subscribe(self, key: str) -> None:
        """Listen to a bus key."""
        self.effects.append(Subscribe(key))

    def unsubscribe(self, key: str) -> None:
        """Listen to it no more."""
        self.effects.append(Unsubscribe(key))

    def instruct(self, instruction: Instruction) -> None:
        """Have the body do something."""
        self.effects.append(Instruct(instruction))

    def record(self, fact: AnyFact) -> None:
        """Write something into the history."""
        self.effects.append(Record(fact))

    def ignore(self, reason: str) -> None:
        """Say why nothing follows from what was heard."""
        self.effects.append(Ignore(reason))

    def commit(self) -> None:
        """What the agent is bound by has changed: write it down before this step's other effects.

        Called as often as anything changes; what is written is how things stand when the step ends.
        """
        self.unwritten = True

    def beat_soon(self, now_s: float) -> None:
        """Send a heartbeat at the end of this step, because it tells something new."""
        self.timers.set(BEAT, now_s)

    def count_beat(self) -> int:
        """Count one more heartbeat. Returns its number."""
        self.beats += 1
        return self.beats

    def beat_again(self, interval_s: float, now_s: float) -> None:
        """It has beaten: do it again after an interval; the first time earlier, by a part that its name gives."""
        if self.beats == 1:
            interval_s *= 0.5 + spread_frac(self._agent) / 2
        self.alarm(BEAT, now_s + interval_s)

    def alarm(self, name: Hashable, at_s: float) -> None:
        """Sound `name` at `at_s`; one that is set already is moved."""
        self.timers.set(name, at_s)

    def cancel(self, name: Hashable) -> None:
        """Do not sound `name`; harmless when it was not set."""
        self.timers.clear(name)

    def awaits(self, name: Hashable) -> bool:
        """Whether an alarm is set."""
        return self.timers.is_set(name)
