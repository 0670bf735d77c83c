"""A vehicle's condition: the reason why it cannot go on, and its reports of that."""

from __future__ import annotations

from dray.body import Charge, ProblemCleared, ProblemRaised
from dray.messages import NOTHING_KNOWN, Problem, ProblemKind
from dray_sim.bodies.reporter import Reporter
from dray_sim.bodies.vehicle.handling import Action
from dray_sim.bodies.vehicle.odometer import Activity
from dray_sim.bodies.vehicle.power import Power

LOAD_SHIFTED = "the load has shifted"
SHIFTED = Problem(kind=ProblemKind.LOAD, passes=False, needs_person=True, load_movable=True)
"""A vehicle's own knowledge of a shifted load."""

LOAD_DROPPED = "the load has fallen off"
"""Reason of a load that has fallen off; the details are those of a shifted load."""

BATTERY_EMPTY = "battery empty"

EMPTY = Problem(kind=ProblemKind.BATTERY, passes=False, needs_person=True, load_movable=True)
"""A vehicle's own knowledge of an empty battery."""


_RAN_FLAT = ProblemRaised(reason=BATTERY_EMPTY, problem=EMPTY)


class Condition:
    """The condition of one vehicle.

    Args:
        power: its battery and its switch.
        reporter: its reports.

    Attributes:
        held: a person has stopped it.
        fault: the fault; empty for none.
        about_fault: details of that fault.
    """

    def __init__(self, power: Power, reporter: Reporter) -> None:
        self.held = False
        self.fault = ""
        self.about_fault = NOTHING_KNOWN
        self._power, self._reporter = power, reporter

    @property
    def problem(self) -> str:
        """The reason why it cannot go on; empty for none."""
        return self.fault or (BATTERY_EMPTY if self._power.empty else "")

    @property
    def about_problem(self) -> Problem:
        """Details of the present problem."""
        return EMPTY if self._power.empty and not self.fault else self.about_fault

    @property
    def stopped(self) -> bool:
        """Whether it is held, broken, empty or off: it neither moves nor goes on with an action."""
        return self.held or bool(self.fault) or self._power.empty or self._power.off

    def activity(self, action: Action | None, *, waits: bool) -> Activity:
        """The activity of a vehicle that does not move.

        Args:
            action: under way; None for none.
            waits: whether its way goes on, and it may not.
        """
        if self._power.off:
            return Activity.OFF
        if self.stopped:
            return Activity.HELD
        if isinstance(action, Charge):
            return Activity.CHARGING
        if action is not None:
            return Activity.HANDLING
        return Activity.WAITING if waits else Activity.IDLE

    def break_down(self, reason: str, problem: Problem) -> None:
        """Something breaks; another breakdown on top of it replaces the reason."""
        self.fault, self.about_fault = reason, problem
        self._reporter.say(ProblemRaised(reason=reason, problem=problem))

    def mend(self) -> None:
        """Clear the fault. An empty battery is another problem, and stays."""
        self.fault, self.about_fault = "", NOTHING_KNOWN
        self._reporter.say(_RAN_FLAT if self._power.empty else ProblemCleared())

    def run_flat(self) -> None:
        """The battery is empty."""
        self._power.level_frac, self._power.empty = 0.0, True
        self._reporter.say(_RAN_FLAT)

    def revive(self) -> None:
        """The battery gives power again."""
        if self._power.empty:
            self._power.empty = False
            if not self.fault:
                self._reporter.say(ProblemCleared())
