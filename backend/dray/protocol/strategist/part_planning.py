"""What parts are made for the orders in work: net of what lies somewhere and of what is in work, in whole containers, in time.

    what open goals still take of a part - pieces that are somewhere - pieces of its goals that are not made yet = what is lacking

Nobody owns a piece before a machine uses it: what is there goes to the goals that are due first, in this reckoning and on the floor. So nothing is to
be put right when a machine fails, a piece is bad, an order is cancelled or somebody has counted wrong: at the next look less or more is
lacking. A goal for a part is of the order for which it was lacking first. What is told may be of different moments, as while a vehicle takes a load
up; so only what is lacking for `SETTLE_S` without a break is given out. The goals of one level are what the next one lacks parts for.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from dray.plant import Plant
from dray.protocol.strategist.order_book import OpenGoal, OrderBook
from dray.protocol.strategist.part_leads import PartLeads
from dray.protocol.strategist.part_stock import PartStock

PLAN_EVERY_S = 5.0
"""So often what is lacking is worked out."""

SETTLE_S = 15.0
"""Longer than the stock of whoever has nothing new to tell is left out of heartbeats."""


@dataclass(frozen=True, slots=True)
class Lack:
    """Pieces of a part that are lacking for a goal."""

    goal: OpenGoal
    part: str
    pieces: int


class PartPlanner:
    """For one strategist.

    Args:
        plant: which items are parts.
        book: all goals.
        stock: what lies where.
        leads: how long goals take.
    """

    def __init__(self, plant: Plant, book: OrderBook, stock: PartStock, leads: PartLeads) -> None:
        self._plant, self._book, self._stock, self._leads = plant, book, stock, leads
        self._lacking: dict[str, tuple[float, int]] = {}
        """By part: since when some is lacking, and the least since then."""

    def plan(self, now_s: float) -> list[OpenGoal]:
        """Add goals for what is lacking; returns them."""
        lacks = list(self._lacks(now_s))
        added: list[OpenGoal] = []
        for part in self._plant.parts:
            of_part = [lack for lack in lacks if lack.part == part]
            pieces = self._settled(part, sum(lack.pieces for lack in of_part), now_s)
            added += self._give_out(of_part, pieces)
        return added

    def _lacks(self, now_s: float) -> Iterator[Lack]:
        """What nothing is there for, of the goals that are due first last."""
        goals = [goal for goal in self._book if not goal.failure and not self._book.order_of(goal).revoked_by]
        there = {part: self._stock.lies(part, now_s) for part in self._plant.parts}
        for goal in goals:
            if goal.work.part_of and goal.work.product in there:
                there[goal.work.product] += goal.work.quantity - goal.arrived
        for goal in sorted(goals, key=lambda each: (each.deadline_s, each.id)):
            for line in goal.work.definition.bill:
                if line.material in there:
                    wanted = line.quantity * goal.to_begin
                    taken = min(wanted, there[line.material])
                    there[line.material] -= taken
                    if taken < wanted:
                        yield Lack(goal, line.material, wanted - taken)

    def _settled(self, part: str, pieces: int, now_s: float) -> int:
        """Of what is lacking now, what has been lacking for long enough."""
        if not pieces:
            self._lacking.pop(part, None)
            return 0
        since_s, least = self._lacking.get(part, (now_s, pieces))
        least = min(least, pieces)
        if now_s < since_s + SETTLE_S:
            self._lacking[part] = since_s, least
            return 0
        self._lacking.pop(part, None)
        return least

    def _give_out(self, lacks: list[Lack], pieces: int) -> list[OpenGoal]:
        """Goals for so many pieces, in whole containers; what is left in one serves the next goal."""
        added: list[OpenGoal] = []
        over = 0
        for lack in lacks:
            missing = min(lack.pieces, pieces) - over
            pieces -= min(lack.pieces, pieces)
            if missing <= 0:
                over = -missing
                continue
            goals = self._book.add_part(lack.goal, lack.part, missing, self._leads.due_s(lack.goal))
            over = sum(goal.work.quantity for goal in goals) - missing
            added += goals
        return added
