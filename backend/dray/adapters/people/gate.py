"""The body of a people's gate of the delivery warehouses: people report how many pieces of which goal have arrived.

    word                is reported as                     is refused
    arrived N of a goal GoodsArrived, N more than before   unlikely: more than is to come, or far from that and from the last load;
                                                           not admitted, also when it is sure: more than is to come

The label of each container shows its goal. An unlikely number is accepted after confirmation; more than the admitted number never counts. A
repeated key gets the same answer. Nobody waits for people: a carrier goes on by its own report, and the order counts the people's report
when it comes. Every report is stored before it is passed on, and passed on before it is answered. After a loss of data the agent gives the
arrived number of each goal (`Admit.arrived`).
"""

from __future__ import annotations

from collections.abc import Callable

from msgspec import Struct
from msgspec.structs import replace

from dray.adapters.people.words import Answered, AnsweredWords, World, is_far, nobody_hears
from dray.body import Admit, GateState, GoodsArrived, Instruction, Report, Word, WordTaken
from dray.messages import CommandRefusal, MachineCommandKind

KEPT_GOALS = 4096
"""Maximum goals remembered, as by any gate: a finished one is remembered for hours."""


class KeptGoal(Struct, frozen=True, omit_defaults=True):
    """One goal at the gate."""

    admitted: int
    arrived: int = 0
    last: int = 0
    """Pieces in the last report."""


class KeptGate(Struct, frozen=True):
    """The gate's memory for the agent's next life."""

    goals: dict[str, KeptGoal] = {}
    """Goals, the longest unchanged first."""
    answered: tuple[Answered, ...] = ()
    """Answers to the last reports, the oldest first."""


DAMAGED_GATE = KeptGate()
"""The memory after unreadable data: empty, until the agent gives the arrived number of each goal."""


class PeopleGate:
    """Implements `dray.ports.Body`.

    Args:
        world: the disk.
        kept: the last life's memory; None for the first one.
        kept_goals: maximum goals remembered.
    """

    def __init__(
        self, world: World[KeptGate], kept: KeptGate | None = None, kept_goals: int = KEPT_GOALS
    ) -> None:
        self._world, self._kept, self._most = world, kept or KeptGate(), kept_goals
        self._answers = AnsweredWords(self._kept.answered)
        self._report: Callable[[Report], None] = nobody_hears

    def instruct(self, instruction: Instruction) -> None:
        """See `dray.ports.Body`."""
        match instruction:
            case Admit():
                self._admit(instruction)
            case Word():
                self._hear(instruction)
            case _:
                return

    def sense(self) -> GateState:
        """See `dray.ports.Body`."""
        arrived = {name: goal.arrived for name, goal in self._kept.goals.items()}
        return GateState(arrived=arrived, people=True)

    def attach(self, report: Callable[[Report], None]) -> None:
        """See `dray.ports.Body`."""
        self._report = report

    def _admit(self, admit: Admit) -> None:
        before = self._kept.goals.get(admit.goal)
        known = before or KeptGoal(0)
        goal = replace(known, admitted=admit.quantity, arrived=max(known.arrived, admit.arrived))
        if goal != before:
            self._kept = replace(self._kept, goals=self._with(admit.goal, goal))
            self._world.remember(self._kept)
        self._report(GoodsArrived(admit.goal, goal.arrived, goal.admitted, by_people=True))

    def _hear(self, word: Word) -> None:
        if (again := self._answers.again(word)) is not None:
            self._report(again)
            return
        refused, detail = self._judge(word)
        kept = replace(self._kept, answered=self._answers.note(Answered(word.key, refused, detail)))
        if refused is None:
            before = kept.goals[word.item]
            arrived = before.arrived + word.quantity
            goal = replace(before, arrived=arrived, last=word.quantity)
            kept = replace(kept, goals=self._with(word.item, goal))
        self._kept = kept
        self._world.remember(kept)
        if refused is None:
            self._report(GoodsArrived(word.item, arrived, goal.admitted, word.vehicle, by_people=True))
        self._report(WordTaken(word.key, refused, detail))

    def _judge(self, word: Word) -> tuple[CommandRefusal | None, str]:
        """The reason to refuse a report, with the expected number."""
        if word.kind is not MachineCommandKind.ARRIVED:
            return CommandRefusal.NOT_SUPPORTED, ""
        goal = self._kept.goals.get(word.item)
        to_come = 0 if goal is None else goal.admitted - goal.arrived
        if goal is None or to_come <= 0:
            return CommandRefusal.NOT_ADMITTED, ""
        if word.quantity <= 0:
            return CommandRefusal.QUANTITY_OUT_OF_RANGE, ""
        if word.quantity > to_come and word.sure:
            return CommandRefusal.NOT_ADMITTED, str(to_come)
        is_doubted = is_far(word.quantity, to_come) and is_far(word.quantity, goal.last)
        if word.quantity > to_come or (is_doubted and not word.sure):
            return CommandRefusal.UNLIKELY, str(to_come)
        return None, ""

    def _with(self, name: str, goal: KeptGoal) -> dict[str, KeptGoal]:
        """All goals with this changed one as the last; above the limit a finished one is forgotten first."""
        goals = {each: known for each, known in self._kept.goals.items() if each != name} | {name: goal}
        if len(goals) > self._most:
            finished = (each for each, known in goals.items() if known.arrived >= known.admitted)
            del goals[next(finished, next(iter(goals)))]
        return goals
