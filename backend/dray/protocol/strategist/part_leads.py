"""Lead time of a goal's parts: learned from goals of its product, plus the carrying."""

from __future__ import annotations

from dray.plant.working_time import WorkingTime
from dray.protocol.strategist.machine_monitor import MachineMonitor
from dray.protocol.strategist.order_book import DELIVERY_S, OpenGoal

WEIGHT = 0.2
"""Weight of the newest goal in the running mean: about the last ten count."""


class PartLeads:
    """The part lead times of one strategist.

    Args:
        machines: the machines, their products, and their own cycle times.
        working_time: of the plant; only working time counts.
    """

    def __init__(self, machines: MachineMonitor, working_time: WorkingTime) -> None:
        self._machines, self._working_time = machines, working_time
        self._piece_s: dict[str, float] = {}
        """By product: seconds per piece since the contract, including other goals of its machine."""

    def due_s(self, goal: OpenGoal) -> float:
        """Deadline of a goal's parts (plant clock)."""
        work = goal.work
        piece_s = self._piece_s.get(work.product, self._machines.cycle_s(work))
        return self._working_time.before_s(goal.deadline_s, work.quantity * piece_s + DELIVERY_S)

    def note(self, goal: OpenGoal, now_s: float) -> None:
        """A goal is made whose begin this life has seen."""
        if goal.taken_s is None:
            return
        took_s = self._working_time.between_s(goal.taken_s, now_s) / goal.work.quantity
        known_s = self._piece_s.get(goal.work.product, took_s)
        self._piece_s[goal.work.product] = known_s + WEIGHT * (took_s - known_s)
