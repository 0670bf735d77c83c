"""A vehicle's problem, and how long its task can wait for a person to solve it (paper, case 4).

A vehicle with a problem keeps its task for a while: what a person solves in a minute needs no second
vehicle. Its heartbeat tells until when it waits, and those who watch it act when that time is
over. When a person promises to come, it waits longer.
"""

from __future__ import annotations

from dray.messages import CommandRefusal, HelpWanted
from dray.messages.command import PROMISE_MAX_S
from dray.messages.fact import HelpAsked, HelpPromised
from dray.protocol.runtime.events import Effect, Record

PATIENCE_MIN_S = 30.0
"""The shortest wait that is asked for, even when the task is late already: in less nobody could help."""

PATIENCE_MAX_S = 180.0
"""Waited for without a promise, however much time the task has."""


class Assistance:
    """What keeps one vehicle from going on.

    Args:
        out: where effects go.
    """

    def __init__(self, out: list[Effect]) -> None:
        self._out = out
        self.problem = ""
        """In words; empty for none."""
        self.help: HelpWanted | None = None
        """Set while its task waits for a person."""
        self._asked = False

    def wait(self, slack_s: float, now_s: float) -> HelpWanted:
        """Let the task wait for a person, once per problem, without asking for one: who stopped the vehicle knows.

        Args:
            slack_s: how much later than expected the task may be done.
            now_s: the present time.
        """
        if self.help is None:
            self.help = HelpWanted(until_s=now_s + min(max(slack_s, PATIENCE_MIN_S), PATIENCE_MAX_S))
        return self.help

    def ask(self, reason: str, task: str, slack_s: float, now_s: float) -> None:
        """Let the task wait for a person, and ask for one, once per problem.

        Args:
            reason: what is wrong, in words.
            task: that waits.
            slack_s: how much later than expected the task may be done.
            now_s: the present time.
        """
        waits = self.wait(slack_s, now_s)
        if not self._asked:
            self._asked = True
            self._out.append(Record(HelpAsked(task=task, reason=reason, until_s=waits.until_s)))

    def promise(self, by: str, wait_s: float | None, now_s: float) -> CommandRefusal | None:
        """A person has promised to come.

        Returns:
            Why that changes nothing; None when the task waits for them now.
        """
        if self.help is None:
            return CommandRefusal.NOT_WAITING
        if wait_s is None or not 0.0 < wait_s <= PROMISE_MAX_S:
            return CommandRefusal.WAIT_OUT_OF_RANGE
        self.help = HelpWanted(until_s=now_s + wait_s, promised_by=by)
        self._out.append(Record(HelpPromised(until_s=self.help.until_s, promised_by=by)))
        return None

    def over(self) -> None:
        """End the wait for a person: the problem is solved, or the task has ended."""
        self.help, self._asked = None, False
