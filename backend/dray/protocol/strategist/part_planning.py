"""Parts to make for the orders in work: net of stock and of part goals, in whole containers, in time.

    pieces that open goals still take - pieces in stock - pieces of its goals that are not made yet = missing pieces

No goal owns a piece before a machine uses it. Stock goes to the goals that are due first, here and on the floor. So
no correction is needed when a machine fails, a piece is bad, an order is cancelled or a count was wrong: the next
plan finds fewer or more missing pieces. A part goal belongs to the order that lacked the part first. Reports may be
of different moments, as while a vehicle loads, so only pieces missing for `SETTLE_S` without a break are ordered.
The goals of one level create the next level's needs.

A goal that no machine has begun is withdrawn when the others would do without all of its pieces for `SETTLE_S`, as
after the cancellation of another order. A begun one is made.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from dray.plant import Plant
from dray.protocol.strategist.order_book import OpenGoal, OrderBook
from dray.protocol.strategist.part_leads import PartLeads
from dray.protocol.strategist.part_stock import PartStock

PLAN_EVERY_S = 5.0
"""Interval of planning (s)."""

SETTLE_S = 15.0
"""Longer than an unchanged stock is omitted from heartbeats (s)."""


@dataclass(frozen=True, slots=True)
class Lack:
    """Missing pieces of a part for a goal."""

    goal: OpenGoal
    part: str
    pieces: int


@dataclass(frozen=True, slots=True)
class Plan:
    """What one planning has found.

    Attributes:
        added: new goals for missing pieces.
        unneeded: goals to withdraw.
    """

    added: list[OpenGoal]
    unneeded: list[OpenGoal]


class PartPlanner:
    """The planner of one strategist.

    Args:
        plant: its parts.
        book: all goals.
        stock: the stock of parts.
        leads: lead times of parts.
    """

    def __init__(self, plant: Plant, book: OrderBook, stock: PartStock, leads: PartLeads) -> None:
        self._plant, self._book, self._stock, self._leads = plant, book, stock, leads
        self._lacking: dict[str, tuple[float, int]] = {}
        """By part: since when pieces are missing, and the minimum since then."""
        self._unneeded: dict[str, float] = {}
        """By goal that is not begun: since when nobody needs it."""

    def plan(self, now_s: float) -> Plan:
        """Add goals for missing pieces, and find goals that nobody needs any more."""
        goals = [goal for goal in self._book if not goal.failure and not self._book.order_of(goal).revoked_by]
        there = {part: self._stock.lies(part, now_s) for part in self._plant.parts}
        lacks = list(self._lacks(goals, there))
        unneeded = self._settled_unneeded(goals, there, now_s)
        added: list[OpenGoal] = []
        for part in self._plant.parts:
            of_part = [lack for lack in lacks if lack.part == part]
            pieces = self._settled(part, sum(lack.pieces for lack in of_part), now_s)
            added += self._give_out(of_part, pieces)
        return Plan(added, unneeded)

    def _lacks(self, goals: list[OpenGoal], there: dict[str, int]) -> Iterator[Lack]:
        """Missing pieces, after stock was assigned to the goals that are due first.

        Args:
            goals: the goals that are made.
            there: by part, the pieces in stock; when it ends, those that no goal takes of these and of the goals' own.
        """
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

    def _settled_unneeded(self, goals: list[OpenGoal], spare: dict[str, int], now_s: float) -> list[OpenGoal]:
        """Goals without whose pieces enough is there, and was for long enough; those without a machine first, and the latest."""
        before, self._unneeded = self._unneeded, {}
        idle = [goal for goal in goals if goal.work.part_of and not goal.is_begun]
        settled: list[OpenGoal] = []
        for goal in sorted(idle, key=lambda each: (bool(each.machine), -each.deadline_s, each.id)):
            part = goal.work.product
            if goal.work.quantity > spare.get(part, 0):
                continue
            spare[part] -= goal.work.quantity
            since_s = self._unneeded[goal.id] = before.get(goal.id, now_s)
            if now_s >= since_s + SETTLE_S:
                settled.append(goal)
        return settled

    def _settled(self, part: str, pieces: int, now_s: float) -> int:
        """The missing pieces that have been missing for long enough."""
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
        """Add goals for `pieces`, in whole containers; the rest of a container serves the next goal."""
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
