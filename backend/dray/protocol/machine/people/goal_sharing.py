"""The goals that a machine works at, and those that it offers to others.

A machine that is out of service, or broken for too long, keeps none. If closures block all ways, it keeps goals
that are not due before one opens. It only offers goals: its strategist moves them to another machine if there is
one. A machine that works again goes on with the remaining ones.
"""

from __future__ import annotations

from dray.protocol.machine.closed_in import ClosedIn
from dray.protocol.machine.material_flow import MaterialFlow
from dray.protocol.machine.people.breakdown import Breakdown
from dray.protocol.machine.production import GoalBook
from dray.protocol.machine.supply import Supply
from dray.protocol.people.out_of_service import ServiceState


class GoalSharing:
    """The goal sharing of one machine.

    Args:
        goals: its goals.
        supply: its supply, whose reorder points depend on the goals at work.
        flow: its material flow.
        breakdown: its breakdown, with the goals' wait.
        service: whether it is out of service.
        closures: whether a way leads to it.
    """

    def __init__(
        self,
        goals: GoalBook,
        supply: Supply,
        flow: MaterialFlow,
        breakdown: Breakdown,
        service: ServiceState,
        closures: ClosedIn,
    ) -> None:
        self._goals = goals
        self._supply = supply
        self._flow = flow
        self._breakdown = breakdown
        self._service = service
        self._closures = closures

    def decide(self, now_s: float) -> bool:
        """Give goals back, or take them up again, by the present state; returns whether that is new."""
        out, is_late = self._service.out, self._breakdown.is_over_patience(now_s)
        finishes = out is not None and out.after_work and not is_late
        keep = next(self._goals.at_work(), None) if finishes else None
        keeps_none = out is not None or is_late
        gives = [
            goal
            for goal in self._goals
            if goal is not keep and (keeps_none or self._closures.keeps_late(goal.deadline_s))
        ]
        gave = self._goals.give_back(gives, now_s)
        is_news = gave or self._goals.take_back(gives)
        if is_news:
            self._supply.goals_changed()
        if gave:
            self._flow.give_back(now_s)
        return is_news
