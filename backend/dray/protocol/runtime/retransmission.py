"""What an agent says again and again, until it is answered: a lost message costs seconds, and nothing else."""

from __future__ import annotations

import msgspec

from dray.messages import Accepted, Message, TakenOver
from dray.protocol.runtime.events import Effect, Send
from dray.protocol.runtime.timers import Timers

ASK_AGAIN_S = 3.0
"""Many times the latency of a good link."""


class Retransmitter:
    """Messages that are repeated, for ever if need be: at most one per task.

    Args:
        alarm: names the alarms, ``(alarm, task)``.
        timers: the agent's alarms.
        out: where effects go.
    """

    __slots__ = ("_alarm", "_out", "_said", "_timers")

    def __init__(self, alarm: str, timers: Timers, out: list[Effect]) -> None:
        self._alarm = alarm
        self._timers = timers
        self._out = out
        self._said: dict[str, tuple[str, Message]] = {}
        """By task: to whom, and what."""

    def __contains__(self, task: str) -> bool:
        """Whether an answer is still waited for."""
        return task in self._said

    def say(self, task: str, to: str, message: Message, now_s: float) -> None:
        """Say this now, and again; it replaces what was said before about the task."""
        self._said[task] = (to, message)
        self.wake(task, now_s)

    def wake(self, task: str, now_s: float) -> None:
        """No answer has come: say it again."""
        said = self._said.get(task)
        if said is not None:
            to, message = said
            if isinstance(message, Accepted | TakenOver):
                message = msgspec.structs.replace(message, at_s=now_s)
            self._out.append(Send(to, message))
            self._timers.set((self._alarm, task), now_s + ASK_AGAIN_S)

    def settle(self, task: str) -> None:
        """It was answered, or nobody needs an answer any more; harmless when nothing was said."""
        self._said.pop(task, None)
        self._timers.clear((self._alarm, task))
