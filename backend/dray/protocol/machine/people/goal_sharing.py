"""Which goals a machine works at, and which it offers to others: one that is out of service, or broken for too long, keeps none.

It offers, and decides nothing: its strategist gives a goal to somebody else where there is somebody, and until then it stays here. A
machine that works again goes on with what nobody has taken.
"""

from __future__ import annotations

from dray.protocol.machine.material_flow import MaterialFlow
from dray.protocol.machine.people.breakdown import Breakdown
from dray.protocol.machine.production import GoalBook
from dray.protocol.machine.supply import Supply
from dray.protocol.people.out_of_service import ServiceState


class GoalSharing:
    """For one machine.

    Args:
        goals: what it has taken.
        supply: its reorder points follow from the goals that it works at.
        flow: what is brought for them.
        breakdown: how long they wait for its end.
        service: whether it is out of service.
    """

    def __init__(
        self,
        goals: GoalBook,
        supply: Supply,
        flow: MaterialFlow,
        breakdown: Breakdown,
        service: ServiceState,
    ) -> None:
        self._goals = goals
        self._supply = supply
        self._flow = flow
        self._breakdown = breakdown
        self._service = service

    def decide(self, now_s: float) -> None:
        """Give goals back, or take them up again, as things stand."""
        out, is_late = self._service.out, self._breakdown.is_over_patience(now_s)
        if out is None and not is_late:
            if self._goals.take_back():
                self._supply.goals_changed()
            return
        finishes = out is not None and out.after_work and not is_late
        keep = next(self._goals.at_work(), None) if finishes else None
        if self._goals.give_back(keep, now_s):
            self._supply.goals_changed()
            self._flow.give_back(now_s)
