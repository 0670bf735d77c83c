"""A machine's breakdown, and how long its goals wait for a repair (paper, case 1).

    room_s      the time left to the most urgent deadline; GOAL_PATIENCE_MIN_S to BREAKDOWN_S
    usual_s     three of five breakdowns of this kind were over by then, by all machines' reports

If such breakdowns are usually over within the room, the goals wait for that long; otherwise they are offered to
others at once. A breakdown known only in words has no usual duration, and the goals wait BREAKDOWN_S. The time
until a person is on duty, or at work by the place's working time, is added. Goals do not wait for too long a
breakdown. A person's word has precedence: goals wait for a person who promises to come, and go if a person has seen
that it takes too long.

In either case a machine that cannot go on calls operators on duty for help, as vehicles do (`protocol.calls`).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from dray.body import Broken, WorkcellState
from dray.memory import ProblemMemory
from dray.messages import (
    NOTHING_KNOWN,
    CommandRefusal,
    HelpWanted,
    Message,
    Problem,
    ProblemEnded,
    ProblemKind,
)
from dray.messages.fact import HelpAsked, HelpPromised
from dray.messages.keys import Keys
from dray.messages.people.command import PROMISE_MAX_S
from dray.plant import Plant
from dray.protocol.calls.help_calls import HelpCalls, PlaceCaller
from dray.protocol.liveness.suspicion import BREAKDOWN_S
from dray.protocol.machine.production import GoalBook
from dray.protocol.people.patience import Experience, calls_after_s, since_s, waits_for_people
from dray.protocol.runtime.life import Life

GOAL_PATIENCE_MIN_S = 60.0
"""Minimum wait of goals, even late ones (s): no person could help sooner, and another machine has to order the material
first."""

PATIENCE_OVER = "patience over"
"""Alarm of the end of the goals' wait."""


class Breakdown:
    """The problem that stops one machine.

    Args:
        plant: its plant.
        goals: its goals, which wait.
        life: the agent's life; its alarm is named `PATIENCE_OVER`.

    Attributes:
        problem: in words; empty for none.
        about: the known facts about it.
        resettable: whether the sensors find no fault any more.
        help: how long the goals wait for a person; None while it works.
        calls: the machine's calls for help, for this problem and others.
        message_handlers: by message type, handlers called with (sender, message, now_s).
        alarms: by name, handlers called with (None, now_s).
    """

    def __init__(self, plant: Plant, goals: GoalBook, life: Life) -> None:
        self._machine, self._keys = life.agent, Keys(plant.id)
        self._goals = goals
        self._life = life
        self._experience = Experience()
        self.calls = HelpCalls(PlaceCaller(plant, life), plant, life)
        self._since_s = self._judged_until_s = self._promised_s = self._comes_after_s = 0.0
        self.problem = ""
        self.about: Problem = NOTHING_KNOWN
        self.resettable = False
        self.help: HelpWanted | None = None
        self.message_handlers: dict[type[Message], Callable[[str, Any, float], None]] = {
            ProblemEnded: self._on_ended,
            **self.calls.message_handlers,
        }
        self.alarms = self.calls.alarms

    def start(
        self, body: WorkcellState, wanted: HelpWanted | None, memory: ProblemMemory | None, now_s: float
    ) -> None:
        """Restore the body's problem and an earlier life's wait, and subscribe."""
        self._life.subscribe(self._keys.all_breakdowns)
        self.calls.listen()
        if body.broken:
            self.help = wanted
            self.on_broken(Broken(body.broken, body.about_problem, body.resettable), now_s)
            self._since_s = since_s(memory, body.about_problem, now_s)
            self._life.commit()

    @property
    def memory(self) -> ProblemMemory | None:
        """The present problem's record for the next life."""
        return ProblemMemory(self.about.kind, self._since_s) if self.problem else None

    def on_broken(self, report: Broken, now_s: float) -> None:
        """The machine stands: compute its goals' wait, once per problem, and ask for a person."""
        is_new = not self.problem or report.problem.kind is not self.about.kind
        self.problem, self.about, self.resettable = report.reason, report.problem, report.resettable
        if not is_new:
            return
        self._since_s, self._comes_after_s = now_s, self.calls.comes_after_s(now_s)
        self._judged_until_s = now_s + self._patience_s(now_s)
        if self.help is None:
            self.help = HelpWanted(until_s=self._judged_until_s)
            waiting = next(iter(self._goals), None)
            asked = HelpAsked(
                task="" if waiting is None else waiting.id,
                reason=self.problem,
                until_s=self.help.until_s,
                problem=self.about,
            )
            self._life.record(asked)
        self._life.alarm(PATIENCE_OVER, self.help.until_s)

    def on_repaired(self, now_s: float) -> None:
        """The machine works again: publish how long the breakdown has lasted."""
        # A breakdown that began in people's absence does not show how long people take.
        teaches = not (self._comes_after_s and waits_for_people(self.about))
        if self.problem and self.about != NOTHING_KNOWN and teaches:
            lasted_s = max(0.0, now_s - self._since_s)
            ended = ProblemEnded(agent=self._machine, problem=self.about, lasted_s=lasted_s)
            self._experience.note(ended, "", now_s)
            self._life.publish(self._keys.breakdown(self._machine), ended)
        self.problem, self.about, self.resettable, self.help = "", NOTHING_KNOWN, False, None
        self._life.cancel(PATIENCE_OVER)

    def update_call(self, now_s: float, *, expected: bool) -> None:
        """Open and close the call for a person.

        Args:
            now_s: the present time.
            expected: whether it should work; out of service, or when it leaves, it calls nobody: people know of it.
        """
        if not self.problem or not expected:
            self.calls.close(now_s)
            return
        after_s = calls_after_s(self.about, now_s - self._since_s)
        self.calls.open(self.about, self.problem, now_s, after_s=after_s)

    def is_over_patience(self, now_s: float) -> bool:
        """Whether its goals' wait is over."""
        return self.help is not None and now_s >= self.help.until_s

    def promise(self, by: str, wait_s: float | None, now_s: float) -> CommandRefusal | None:
        """A person promises to come. Returns the refusal; None if the goals wait for the person now."""
        if self.help is None:
            return CommandRefusal.NOT_WAITING
        if wait_s is None or not 0.0 < wait_s <= PROMISE_MAX_S:
            return CommandRefusal.WAIT_OUT_OF_RANGE
        self.help, self._promised_s = HelpWanted(until_s=now_s + wait_s, promised_by=by), now_s
        self._life.alarm(PATIENCE_OVER, self.help.until_s)
        self._life.record(HelpPromised(until_s=self.help.until_s, promised_by=by))
        return None

    def let_go(self, now_s: float) -> CommandRefusal | None:
        """A person says that it takes too long. Returns the refusal; None if the goals go to others now."""
        if self.help is None:
            return CommandRefusal.NOT_WAITING
        self._judged_until_s = min(self.help.until_s, now_s)
        self.help = HelpWanted(until_s=self._judged_until_s)
        self._life.cancel(PATIENCE_OVER)
        return None

    def not_coming(self, since_s: float) -> None:
        """The person expected since then does not come: later promises are void."""
        if self.help is not None and self.help.promised_by and self._promised_s >= since_s:
            self.help = HelpWanted(until_s=self._judged_until_s)
            self._life.alarm(PATIENCE_OVER, self.help.until_s)

    def _patience_s(self, now_s: float) -> float:
        if self.about.kind is ProblemKind.UNKNOWN and not self.about.passes:
            return BREAKDOWN_S if self._comes_after_s <= BREAKDOWN_S else 0.0
        room_s = min(max(self._goals.slack_s(now_s), GOAL_PATIENCE_MIN_S), BREAKDOWN_S)
        return room_s if self._experience.usual_s(self.about, now_s, self._comes_after_s) <= room_s else 0.0

    def _on_ended(self, sender: str, message: ProblemEnded, now_s: float) -> None:
        if sender != self._machine:
            self._experience.note(message, sender, now_s)
