"""How long before a goal is due its parts should be made: what was learned of goals of its product, and the carrying."""

from __future__ import annotations

from dray.plant.working_time import WorkingTime
from dray.protocol.strategist.machine_monitor import MachineMonitor
from dray.protocol.strategist.order_book import DELIVERY_S, OpenGoal

WEIGHT = 0.2
"""Of the newest goal in the running mean: about the last ten count."""


class PartLeads:
    """For one strategist.

    Args:
        machines: who makes what, and how fast by their own word.
        working_time: of the plant; only working time counts.
    """

    def __init__(self, machines: MachineMonitor, working_time: WorkingTime) -> None:
        self._machines, self._working_time = machines, working_time
        self._piece_s: dict[str, float] = {}
        """By product, seconds for one piece from the contract on, other goals of its machine included."""

    def due_s(self, goal: OpenGoal) -> float:
        """By when the parts of a goal should be made (plant clock)."""
        work = goal.work
        piece_s = self._piece_s.get(work.product, self._machines.cycle_s(work))
        return self._working_time.before_s(goal.deadline_s, work.quantity * piece_s + DELIVERY_S)

    def note(self, goal: OpenGoal, now_s: float) -> None:
        """A goal is made that this life has seen begin."""
        if goal.taken_s is None:
            return
        took_s = self._working_time.between_s(goal.taken_s, now_s) / goal.work.quantity
        known_s = self._piece_s.get(goal.work.product, took_s)
        self._piece_s[goal.work.product] = known_s + WEIGHT * (took_s - known_s)
