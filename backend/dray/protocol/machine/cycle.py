"""A machine's cycle: one piece at a time, for the most urgent goal whose material is at hand."""

from __future__ import annotations

from collections.abc import Callable

from dray.body import StartCycle
from dray.messages.fact import PieceMade
from dray.protocol.machine.production import Goal, GoalBook
from dray.protocol.machine.supply import Supply
from dray.protocol.runtime.events import Effect, Instruct, Record


class Cycle:
    """The running cycle of one machine, if there is one.

    Args:
        goals: what is to be made.
        supply: what is at hand.
        out: where effects go.
        commit: called when a goal has got a piece.

    Attributes:
        product: what is being made; empty for nothing.
    """

    def __init__(
        self, goals: GoalBook, supply: Supply, out: list[Effect], commit: Callable[[], None]
    ) -> None:
        self._goals = goals
        self._supply = supply
        self._out = out
        self._commit = commit
        self._goal: Goal | None = None
        """What the piece is for; None for a cycle that an earlier life of this machine has begun."""
        self.product = ""

    def start(self) -> None:
        """Begin the next one, unless one runs or nothing can be made."""
        if self.product:
            return
        goal = self._goals.next_to_make(self._supply.stock)
        if goal is None:
            return
        self._goal, self.product = goal, goal.work.product
        bill = goal.work.definition.bill
        for line in bill:
            self._supply.use(line.material, line.quantity)
        cycle_s = self._goals.products.cycle_s(goal.work)
        self._out.append(Instruct(StartCycle(product=self.product, bill=bill, cycle_s=cycle_s)))

    def done(self, product: str, seq: int) -> None:
        """A piece has come out; it is spare when its goal has ended meanwhile."""
        if not self._supply.change(product, 1, seq):
            return  # It lay there at the start, when all that did was counted.
        goal, self._goal, self.product = self._goal, None, ""
        if goal is None or self._goals.get(goal.id) is not goal:
            self._goals.add_spare(product, 1)
        else:
            goal.made += 1
            self._note_made(goal)

    def failed(self) -> None:
        """It has ended without a piece; the senses tell what has become of its material."""
        self._goal, self.product = None, ""

    def share_spare(self) -> None:
        """Finished pieces of goals that ended early serve the next ones."""
        for goal in self._goals.at_work():
            if self._goals.use_spare(goal, self._goal):
                self._note_made(goal)

    def _note_made(self, goal: Goal) -> None:
        self._commit()
        made = goal.told_made
        self._out.append(Record(PieceMade(goal=goal.id, product=goal.work.product, made=made)))
