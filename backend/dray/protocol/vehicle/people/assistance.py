"""A vehicle's problem, and how long its task waits for it to end (paper, case 4).

A vehicle with a problem keeps its task for a while: what a person solves in a minute needs no second
vehicle. Its heartbeat tells until when it waits, and those who watch it act when that time is
over. How long that is, is judged by `patience`. A person's word counts above: one who promises to come is waited
for, and one who has seen that it cannot be mended there lets the task go at once.
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
        task: its name.
        slack_s: how much later than now expected it may be done.
        relief_s: how much later than this vehicle another one would be done.
        irreplaceable: nobody else can carry it, as goods that are on board already.
    """

    task: str
    slack_s: float = 0.0
    relief_s: float = 0.0
    irreplaceable: bool = False

    @property
    def room_s(self) -> float:
        """How long it can wait."""
        return room_s(self.slack_s, self.relief_s)


class Assistance:
    """What keeps one vehicle from going on."""

    def __init__(self, life: Life) -> None:
        self._life = life
        self.problem = ""
        """In words; empty for none."""
        self.about: Problem = NOTHING_KNOWN
        """What is known of it."""
        self.help: HelpWanted | None = None
        """Set while its task waits for a person."""
        self._judged_until_s = 0.0
        """How long the task waits while nobody has promised to come."""
        self._promised_s = 0.0
        """When the present promise was made."""
        self._asked = False
        self._irreplaceable = False

    def wait(self, waiting: Waiting, now_s: float) -> HelpWanted:
        """Let the task wait for a person, once per problem, without asking for one: who stopped the vehicle knows."""
        self._irreplaceable = waiting.irreplaceable
        if self.help is None:
            self._judged_until_s = now_s + waiting.room_s
            self.help = HelpWanted(until_s=self._judged_until_s)
        return self.help

    def ask(self, waiting: Waiting, usual_s: float, now_s: float) -> None:
        """Let the task wait for the problem to end, or go at once, and ask for a person, once per problem.

        Args:
            waiting: the task.
            usual_s: how long such a problem lasts, more probably than not at most.
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
            Why that changes nothing; None when the task waits for them now.
        """
        if self.help is None:
            return CommandRefusal.NOT_WAITING
        if wait_s is None or not 0.0 < wait_s <= PROMISE_MAX_S:
            return CommandRefusal.WAIT_OUT_OF_RANGE
        self.help, self._promised_s = HelpWanted(until_s=now_s + wait_s, promised_by=by), now_s
        self._life.record(HelpPromised(until_s=self.help.until_s, promised_by=by))
        return None

    def not_coming(self, since_s: float) -> bool:
        """Who was expected since then does not come: the task waits as it would without what was promised since.

        Returns:
            Whether that changes anything.
        """
        if self.help is None or not self.help.promised_by or self._promised_s < since_s:
            return False
        self.help = HelpWanted(until_s=self._judged_until_s)
        return True

    def let_go(self, now_s: float) -> CommandRefusal | None:
        """A person has said that it cannot be mended there: the task waits no more, whatever was promised.

        Returns:
            Why that changes nothing; None when the task goes to another vehicle now.
        """
        if self.help is None:
            return CommandRefusal.NOT_WAITING
        if self._irreplaceable:
            return CommandRefusal.LOAD_ABOARD
        self._judged_until_s = min(self.help.until_s, now_s)
        self.help = HelpWanted(until_s=self._judged_until_s)
        return None

    def over(self) -> None:
        """End the wait for a person: the problem is solved, or the task has ended."""
        self.help, self._asked, self._irreplaceable = None, False, False
