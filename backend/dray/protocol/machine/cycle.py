"""A machine's cycle: one piece at a time, for the most urgent goal whose material is available.

No cycle begins outside the machine's working time; a running cycle is finished.
"""

from __future__ import annotations

from collections.abc import Callable

from dray.body import StartCycle
from dray.messages import Production
from dray.messages.fact import PieceMade, PieceScrapped, SparePieceMade
from dray.protocol.machine.documents import GoalDocuments
from dray.protocol.machine.production import Goal, GoalBook
from dray.protocol.machine.supply import Supply
from dray.protocol.runtime.life import Life

WORKING_TIME = "working time"
"""Alarm: the machine begins to work, or to rest."""


class Cycle:
    """The running cycle of one machine, if there is one.

    Args:
        goals: the machine's goals.
        supply: its stock.
        documents: the documents of its goals.

    Attributes:
        product: the product in work; empty for none.
        rests: whether the machine rests by its working time.
        blocked: whether only room is missing for the next piece.
    """

    def __init__(self, goals: GoalBook, supply: Supply, documents: GoalDocuments, life: Life) -> None:
        self._goals = goals
        self._supply = supply
        self._documents = documents
        self._life = life
        self.goal: Goal | None = None
        """The goal of the running cycle; None for a cycle of an earlier life."""
        self.product = ""
        self.rests = False
        self.blocked = False

    def look(self, now_s: float) -> None:
        """Update work or rest by the clock, and set the alarm of the next change."""
        working_time = self._goals.working_time
        if not working_time.is_always:
            self.rests = not working_time.is_on(now_s)
            self._life.alarm(WORKING_TIME, working_time.next_change_s(now_s))

    def start(self, has_room: Callable[[Production], bool]) -> None:
        """Begin the next cycle, unless one runs, the machine rests or no piece can be made.

        Args:
            has_room: whether there is room for a piece among the goods.
        """
        self.blocked = False
        if self.product or self.rests:
            return
        stock, ready = self._supply.stock, self._documents.ready
        goal = self._goals.next_to_make(stock, lambda work: ready(work) and has_room(work))
        if goal is None:
            self.blocked = self._goals.next_to_make(stock, ready) is not None
            return
        self.goal, self.product = goal, goal.work.product
        bill = goal.work.definition.bill
        for line in bill:
            self._supply.use(line.material, line.quantity)
        cycle_s = self._goals.products.cycle_s(goal.work)
        self._life.instruct(StartCycle(product=self.product, bill=bill, cycle_s=cycle_s))

    def done(self, product: str, seq: int, *, bad: bool = False) -> None:
        """A piece is done. It is spare if its goal has ended, or if it is a part."""
        if not self._supply.change(product, 0 if bad else 1, seq):
            return  # It was in the initial count.
        if self.product and product != self.product:
            # People have made another product meanwhile: the running cycle goes on.
            if bad:
                self._life.record(PieceScrapped(product))
            else:
                self._goals.add_spare(product, 1)
                self._life.record(SparePieceMade(product))
            return
        goal, self.goal, self.product = self.goal, None, ""
        lives = goal is not None and self._goals.get(goal.id) is goal
        if bad:
            self._life.record(PieceScrapped(product, goal.id if goal is not None and lives else ""))
            return
        if goal is None or not lives or goal.is_of_parts:
            self._goals.add_spare(product, 1)
        if goal is not None and lives:
            goal.note_made(1)
            self._note_made(goal)
        else:
            self._life.record(SparePieceMade(product))

    def failed(self) -> None:
        """The cycle has ended without a piece; the body's stock shows what became of its material."""
        self.goal, self.product = None, ""

    def share_spare(self) -> None:
        """Give spare pieces of ended goals to the next ones."""
        for goal in self._goals.at_work():
            if self._goals.use_spare(goal, self.goal):
                self._note_made(goal, from_stock=True)

    def _note_made(self, goal: Goal, *, from_stock: bool = False) -> None:
        self._life.commit()
        made = PieceMade(goal.id, goal.work.product, goal.reported_made, from_stock)
        self._life.record(made)
