"""The controller of a simulated machine: it counts pieces, shows bits and obeys bits, like a PLC in the field.

It knows nothing of materials, tasks and agents. Its connection carries its signals, and what is written to it.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from dray.adapters.signals.signal import Signal, Value
from dray.body import (
    Broken,
    CycleDone,
    Repaired,
    Report,
    ResetFault,
    SetPace,
    StartCycle,
)
from dray.ports import Clock
from dray_sim.bodies.workcell import SimWorkcell
from dray_sim.controllers.alive import Alive
from dray_sim.controllers.dock import LOOK_S, ControlledDock

MODULUS = 2**16
"""Modulus of its counters: those of a PLC are words."""

COUNTERS = Signal.PIECES, Signal.BAD


class MachineController:
    """A machine's controller.

    Args:
        workcell: the machine; its reports are the controller's from now on.
        clock: the plant's.
        tell: is given each value that changes, and none twice.
        modulus: at which the counters roll over.
        rest_s: shortest time after a piece before it begins another one. Where `RUN` arrives late, it has been
            switched off by then if no piece is wanted.
        still_s: time without a new `alive` after which it begins no piece; infinite where only `miss_alive` counts.

    Attributes:
        shows: values of its outputs, by signal.
        told: values of its inputs, by signal.
        made: pieces that it has counted since it was built or its counters were reset, by counter.
    """

    def __init__(
        self,
        workcell: SimWorkcell,
        clock: Clock,
        tell: Callable[[Signal, Value], None],
        *,
        modulus: int = MODULUS,
        rest_s: float = 0.0,
        still_s: float = math.inf,
    ) -> None:
        self._workcell, self._clock, self._tell = workcell, clock, tell
        self._modulus, self._rest_s = modulus, rest_s
        self._rests_until_s = clock.now_s()
        self._alive = Alive(clock, still_s)
        self.made = dict.fromkeys(COUNTERS, 0)
        self.shows: dict[Signal, Value] = {
            Signal.PIECES: 0,
            Signal.BAD: 0,
            Signal.FAULT: bool(workcell.broken),
            Signal.FAULT_TEXT: workcell.broken,
            Signal.DOCK_READY: False,
        }
        self.told: dict[Signal, Value] = {
            Signal.RUN: False,
            Signal.PRODUCT: "",
            Signal.SPEED: 1.0,
            Signal.RESET: False,
            Signal.DOCK_PERMIT: False,
            Signal.DOCK_VEHICLE: "",
            Signal.ALIVE: 0,
        }
        self._speed_frac = 1.0
        self._more: int | None = None
        """Pieces that it begins while `alive` stands still; None while that counts."""
        self._dock = ControlledDock(
            workcell, clock.now_s(), lambda is_ready: self._show(Signal.DOCK_READY, is_ready)
        )
        workcell.attach(self._heard)
        clock.call_at(clock.now_s(), self._look)

    def on_write(self, signal: Signal, value: Value) -> None:
        """Store an input; the controller acts on it when it looks."""
        if signal in self.told:
            self.told[signal] = value
        if signal is Signal.ALIVE:
            self._alive.beat(value)
        if signal is Signal.RUN:
            self._more = None

    def miss_alive(self, more: int = 0) -> None:
        """`alive` stands still: it finishes its piece, and begins none until `run` is written again.

        Args:
            more: pieces that it begins before it notices, if `run` is true.
        """
        self._more = more

    def reset_counters(self) -> None:
        """Count from 0 on, as after somebody has pressed a button at its panel."""
        for signal in COUNTERS:
            self.made[signal] = 0
            self._show(signal, 0)

    # --- what it shows ---

    def _show(self, signal: Signal, value: Value) -> None:
        if self.shows[signal] != value:
            self.shows[signal] = value
            self._tell(signal, value)

    def _heard(self, report: Report) -> None:
        match report:
            case CycleDone(bad=bad):
                signal = Signal.BAD if bad else Signal.PIECES
                self.made[signal] += 1
                self._rests_until_s = self._clock.now_s() + self._rest_s
                self._show(signal, self.made[signal] % self._modulus)
            case Broken(reason=reason):
                self._show(Signal.FAULT_TEXT, reason)
                self._show(Signal.FAULT, True)
            case Repaired():
                self._show(Signal.FAULT, False)
                self._show(Signal.FAULT_TEXT, "")

    # --- what it does ---

    def _look(self) -> None:
        now_s = self._clock.now_s()
        self._clock.call_at(now_s + LOOK_S, self._look)
        if self._workcell.off:
            self._dock.lose_power(now_s)
            return
        if self.told[Signal.RESET] and self._workcell.broken:
            self._workcell.instruct(ResetFault())
        speed_frac = float(self.told[Signal.SPEED])
        if speed_frac != self._speed_frac and 0.0 < speed_frac <= 1.0:
            self._speed_frac = speed_frac
            self._workcell.instruct(SetPace(speed_frac=speed_frac))
        runs = self.told[Signal.RUN] and self._more != 0 and not self._alive.stands
        if runs and now_s >= self._rests_until_s and not self._workcell.sense().cycling:
            self._workcell.instruct(StartCycle(product=str(self.told[Signal.PRODUCT])))
            if self._more and self._workcell.sense().cycling:
                self._more -= 1
        vehicle = str(self.told[Signal.DOCK_VEHICLE]) if self.told[Signal.DOCK_PERMIT] else ""
        self._dock.look(vehicle, now_s)
