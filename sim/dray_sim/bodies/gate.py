"""The gate of the delivery warehouses: it counts goods in by goal, and lets in no more than its agent admits.

It is the body (`dray.ports.Body`) of the gate's agent (`dray.protocol.gate`). Goals are fenced only here. A machine
that was given up may live on behind a broken network and send its goods. The gate, which was shut for its goal,
refuses these surplus pieces. So every ordered piece gets in exactly once (invariant 4), without a lease. Goods go on
arriving while strategists and the gate's own agent are away.

It decides nothing, and refused goods stay with their carrier. It is hardware that outlives every restart of its
agent, which then senses the arrivals it missed.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from dray.body import Admit, GateState, GoodsArrived, Instruction, Report
from dray.ports import Clock
from dray_sim.bodies.reporter import Reporter

NOT_ADMITTED = "not admitted"

KEPT_GOALS = 4096
"""Largest number of goals in its memory. The large plant works on some hundred at a time and closes thousands in a
day. So a finished goal is remembered for hours; goods are on the road for minutes."""


@dataclass(slots=True)
class _Permit:
    """The permit of one goal."""

    admitted: int
    arrived: int = 0


class Gate:
    """Implements `dray.ports.Body`; the delivery warehouses of a plant share one.

    Invariants: pieces of a goal get in only while no more than admitted are in; what has arrived never falls. A full
    memory forgets the goal that was quiet the longest, a finished one first. The goods of a forgotten goal are
    refused like those of a goal that was never admitted. So forgetting can hold a piece up, but never lets one in
    twice.

    Args:
        clock: the plant's clock.
        kept: how many goals it keeps in mind.

    Attributes:
        is_open: it lets everything in and still counts; people stand for its agent's body, and report arrivals.
    """

    def __init__(self, clock: Clock, kept: int = KEPT_GOALS) -> None:
        self._clock = clock
        self._reporter = Reporter(clock)
        self._kept = kept
        self.is_open = False
        self._permits: dict[str, _Permit] = {}
        """Ordered by the last `Admit` or arrival of each, so that the quietest stands first."""

    # --- Body ------------------------------------------------------------------------------------

    def instruct(self, instruction: Instruction) -> None:
        """See `dray.ports.Body`. Other instructions are ignored: no report would fit them."""
        if isinstance(instruction, Admit):
            self._reporter.say(self.admit(instruction))
            self._reporter.flush_soon()

    def sense(self) -> GateState:
        """See `dray.ports.Body`."""
        return GateState(arrived={goal: permit.arrived for goal, permit in sorted(self._permits.items())})

    def attach(self, report: Callable[[Report], None]) -> None:
        """See `dray.ports.Body`."""
        self._reporter.attach(report)

    # --- the world -------------------------------------------------------------------------------

    def arrived(self, goal: str) -> int:
        """Pieces of a goal that are in; 0 for one that it does not know."""
        permit = self._permits.get(goal)
        return 0 if permit is None else permit.arrived

    def enter(self, goal: str, quantity: int, vehicle: str = "") -> str:
        """Let pieces of a goal in, wholly or not at all. Returns "" when they are in, else why not."""
        if self.is_open:
            self.admit(Admit(goal, self.arrived(goal) + quantity))
        permit = self._permits.get(goal)
        if permit is None or permit.arrived + quantity > permit.admitted:
            return NOT_ADMITTED
        permit.arrived += quantity
        self._renew(goal, permit)
        told = GoodsArrived(goal=goal, arrived=permit.arrived, admitted=permit.admitted, vehicle=vehicle)
        self._reporter.say(told)
        self._reporter.flush_soon()
        return ""

    # --- how it is done --------------------------------------------------------------------------

    def admit(self, admit: Admit) -> GoodsArrived:
        """Let in as many pieces of a goal as this says; returns the answer."""
        goal = admit.goal
        permit = self._permits.get(goal)
        if permit is None:
            if len(self._permits) >= self._kept:
                self._forget_one()
            permit = _Permit(admit.quantity)
        permit.admitted = admit.quantity
        self._renew(goal, permit)
        return GoodsArrived(goal=goal, arrived=permit.arrived, admitted=permit.admitted)

    def _renew(self, goal: str, permit: _Permit) -> None:
        """Put a goal at the end of those that may be forgotten."""
        self._permits.pop(goal, None)
        self._permits[goal] = permit

    def _forget_one(self) -> None:
        quietest = next(iter(self._permits))
        finished = (goal for goal, permit in self._permits.items() if permit.arrived >= permit.admitted)
        del self._permits[next(finished, quietest)]
