"""The controller of a simulated gate: a belt before it, a reader of labels and a counter.

Vehicles put their containers on the belt at any time. The controller shows one label after the other, lets a
container in when it is told to, and counts its pieces. A container that is not admitted goes aside.
"""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Callable

from dray.adapters.signals.signal import Signal, Value
from dray.body import GoodsArrived, Report
from dray.ports import Clock
from dray_sim.bodies.gate import Gate
from dray_sim.controllers.alive import STILL_S, Alive
from dray_sim.controllers.dock import LOOK_S

ASIDE_S = 600.0
"""Default time after which a container that is not admitted goes aside; time in which the agent is away does not count."""

BEAT_S = 60.0
"""Longest time between two values of `alive` that counts as time in which a container was not admitted. They come once a real second."""

MODULUS = 2**16
"""Modulus of its counter."""


class GateController:
    """A gate's controller.

    Args:
        gate: the gate, which is open for everything from now on; its reports are the controller's.
        clock: the plant's.
        tell: is given each value that changes, and none twice.
        aside_s: time after which a container that is not admitted goes aside.
        still_s: time without a new `alive` after which nothing is let in.

    Attributes:
        shows: values of its outputs, by signal.
        told: values of its inputs, by signal.
        let_in: pieces that came in, by goal.
        aside: pieces that went aside, by goal.
    """

    def __init__(
        self,
        gate: Gate,
        clock: Clock,
        tell: Callable[[Signal, Value], None],
        *,
        aside_s: float = ASIDE_S,
        still_s: float = STILL_S,
    ) -> None:
        self._clock, self._tell, self._aside_s = clock, tell, aside_s
        self._alive = Alive(clock, still_s)
        self.shows: dict[Signal, Value] = {Signal.PIECES: 0, Signal.GOAL: ""}
        self.told: dict[Signal, Value] = {Signal.ADMITTED: 0, Signal.ADMITTED_GOAL: "", Signal.ALIVE: 0}
        self.let_in: Counter[str] = Counter()
        self.aside: Counter[str] = Counter()
        self._belt: deque[tuple[str, int]] = deque()
        """Containers that wait: goal and pieces."""
        self._brought: Counter[str] = Counter(gate.sense().arrived)
        self._pieces = self._made = 0
        """Pieces of the container whose label is shown; pieces that were let in since its counter was reset."""
        self._waited_s, self._beat_s = 0.0, clock.now_s()
        """Time for which the container has waited while the agent was there; the time of the last value of `alive`."""
        gate.is_open = True
        gate.attach(self._heard)
        clock.call_at(clock.now_s(), self._look)

    def on_write(self, signal: Signal, value: Value) -> None:
        """Store an input; the controller acts on it when it looks."""
        if signal not in self.told:
            return
        if signal is Signal.ALIVE:
            self._alive.beat(value)
        if signal is Signal.ALIVE and value != self.told[signal]:
            now_s = self._clock.now_s()
            self._waited_s += min(now_s - self._beat_s, BEAT_S)
            self._beat_s = now_s
        self.told[signal] = value

    def reset_counters(self) -> None:
        """Count from 0 on, as after somebody has pressed a button at its panel."""
        self._made = 0
        self._show(Signal.PIECES, 0)

    def _show(self, signal: Signal, value: Value) -> None:
        if self.shows[signal] != value:
            self.shows[signal] = value
            self._tell(signal, value)

    def _heard(self, report: Report) -> None:
        if isinstance(report, GoodsArrived):
            pieces = report.arrived - self._brought[report.goal]
            self._brought[report.goal] += pieces
            if pieces > 0:
                self._belt.append((report.goal, pieces))

    def _look(self) -> None:
        now_s = self._clock.now_s()
        self._clock.call_at(now_s + LOOK_S, self._look)
        label, admitted = str(self.shows[Signal.GOAL]), int(self.told[Signal.ADMITTED])
        if not label:
            # The permit of the last container must have been taken back.
            if self._belt and not admitted:
                goal, self._pieces = self._belt.popleft()
                self._waited_s, self._beat_s = 0.0, now_s
                self._show(Signal.GOAL, goal)
        elif self.told[Signal.ADMITTED_GOAL] == label and admitted >= self._pieces and not self._alive.stands:
            self._made += self._pieces
            self.let_in[label] += self._pieces
            self._show(Signal.PIECES, self._made % MODULUS)
            self._show(Signal.GOAL, "")
        elif self._waited_s > self._aside_s:
            self.aside[label] += self._pieces
            self._show(Signal.GOAL, "")
