"""A vehicle's problem, and how long its task waits for a solution (paper, case 4).

A vehicle with a problem keeps its task for a while: a problem of a minute needs no second vehicle. Its heartbeat
tells how long it waits; its observers act after that. `patience` computes that time. A person's word has
precedence: the task waits for a person who promises to come. It goes at once if a person has seen that repair there
is impossible.
"""

from __future__ import annotations

from dataclasses import dataclass

from dray.messages import NOTHING_KNOWN, CommandRefusal, HelpWanted, Problem
from dray.messages.fact import HelpAsked, HelpPromised
from dray.messages.people.command import PROMISE_MAX_S
from dray.protocol.people.patience import room_s
from dray.protocol.runtime.life import Life


@dataclass(frozen=True, slots=True)
class Waiting:
    """The task of a vehicle that cannot go on.

    Attributes:
        task: its id.
        slack_s: how much later than expected it may be done.
        relief_s: how much later than this vehicle another one would be done.
        irreplaceable: whether no other vehicle can carry it, as goods on board.
    """

    task: str
    slack_s: float = 0.0
    relief_s: float = 0.0
    irreplaceable: bool = False

    @property
    def room_s(self) -> float:
        """How long it can wait (s)."""
        return room_s(self.slack_s, self.relief_s)


class Assistance:
    """The problem that stops one vehicle."""

    def __init__(self, life: Life) -> None:
        self._life = life
        self.problem = ""
        """The problem in words; empty for none."""
        self.about: Problem = NOTHING_KNOWN
        """The known facts about the problem."""
        self.help: HelpWanted | None = None
        """The request for help; set while the task waits for a person."""
        self._judged_until_s = 0.0
        """End of the wait without a promise (plant clock, s)."""
        self._promised_s = 0.0
        """Time of the present promise (plant clock, s)."""
        self._asked = False
        self._irreplaceable = False

    def wait(self, waiting: Waiting, now_s: float) -> HelpWanted:
        """Let the task wait for a person, once per problem, without a request: the person who stopped the vehicle knows."""
        self._irreplaceable = waiting.irreplaceable
        if self.help is None:
            self._judged_until_s = now_s + waiting.room_s
            self.help = HelpWanted(until_s=self._judged_until_s)
        return self.help

    def ask(self, waiting: Waiting, usual_s: float, now_s: float) -> None:
        """Let the task wait for a solution, or go at once, and ask for a person, once per problem.

        Args:
            waiting: the task.
            usual_s: the expected duration of such a problem (s).
            now_s: the present time.
        """
        wanted = self.wait(waiting, now_s)
        if usual_s > waiting.room_s and not waiting.irreplaceable:
            self._judged_until_s = min(self._judged_until_s, now_s)
            if not wanted.promised_by:
                wanted = self.help = HelpWanted(until_s=self._judged_until_s)
        if not self._asked:
            self._asked = True
            fact = HelpAsked(
                task=waiting.task, reason=self.problem, until_s=wanted.until_s, problem=self.about
            )
            self._life.record(fact)

    def promise(self, by: str, wait_s: float | None, now_s: float) -> CommandRefusal | None:
        """A person has promised to come.

        Returns:
            The refusal; None if the task waits for the person now.
        """
        if self.help is None:
            return CommandRefusal.NOT_WAITING
        if wait_s is None or not 0.0 < wait_s <= PROMISE_MAX_S:
            return CommandRefusal.WAIT_OUT_OF_RANGE
        self.help, self._promised_s = HelpWanted(until_s=now_s + wait_s, promised_by=by), now_s
        self._life.record(HelpPromised(until_s=self.help.until_s, promised_by=by))
        return None

    def not_coming(self, since_s: float) -> bool:
        """The person expected since then does not come: later promises are void.

        Returns:
            Whether that changes the wait.
        """
        if self.help is None or not self.help.promised_by or self._promised_s < since_s:
            return False
        self.help = HelpWanted(until_s=self._judged_until_s)
        return True

    def let_go(self, now_s: float) -> CommandRefusal | None:
        """A person has said that repair there is impossible: the wait ends in spite of any promise.

        Returns:
            The refusal; None if the task goes to another vehicle now.
        """
        if self.help is None:
            return CommandRefusal.NOT_WAITING
        if self._irreplaceable:
            return CommandRefusal.LOAD_ABOARD
        self._judged_until_s = min(self.help.until_s, now_s)
        self.help = HelpWanted(until_s=self._judged_until_s)
        return None

    def over(self) -> None:
        """End the wait: the problem is solved, or the task has ended."""
        self.help, self._asked, self._irreplaceable = None, False, False
