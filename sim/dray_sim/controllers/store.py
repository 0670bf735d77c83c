"""The controller of a simulated storage or source warehouse: a dock that makes itself safe, and a scale for each material.

It knows nothing of reservations, tasks and agents. Its connection carries its signals, and what is written to it.
"""

from __future__ import annotations

from collections.abc import Callable

from dray.adapters.signals.signal import LEVEL, Signal, Value
from dray.body import Refill, Report, StockChanged
from dray.ports import Clock
from dray_sim.bodies.stores import Storage
from dray_sim.controllers.dock import LOOK_S, ControlledDock


class StoreController:
    """A storage's controller.

    A storage that fills itself is filled up after every removal: a controller is not told what is short.

    Args:
        storage: the storage; its reports are the controller's from now on.
        clock: the plant's.
        tell: is given each value that changes, and none twice.

    Attributes:
        shows: values of its outputs, by signal.
        told: values of its inputs, by signal.
    """

    def __init__(self, storage: Storage, clock: Clock, tell: Callable[[str, Value], None]) -> None:
        self._storage, self._clock, self._tell = storage, clock, tell
        self.shows: dict[str, Value] = {
            Signal.DOCK_READY: False,
            **{LEVEL + item: pieces for item, pieces in storage.stock.items()},
        }
        self.told: dict[Signal, Value] = {
            Signal.DOCK_PERMIT: False,
            Signal.DOCK_VEHICLE: "",
            Signal.ALIVE: 0,
        }
        self._dock = ControlledDock(
            storage, clock.now_s(), lambda is_ready: self._show(Signal.DOCK_READY, is_ready)
        )
        storage.attach(self._heard)
        clock.call_at(clock.now_s(), self._look)

    def on_write(self, signal: Signal, value: Value) -> None:
        """Store an input; the controller acts on it when it looks."""
        if signal in self.told:
            self.told[signal] = value

    def _show(self, name: str, value: Value) -> None:
        if self.shows[name] != value:
            self.shows[name] = value
            self._tell(name, value)

    def _heard(self, report: Report) -> None:
        if isinstance(report, StockChanged) and report.item in self._storage.stock:
            self._show(LEVEL + report.item, self._storage.stock[report.item])
            if report.change < 0:
                self._storage.instruct(Refill(item=report.item))

    def _look(self) -> None:
        now_s = self._clock.now_s()
        self._clock.call_at(now_s + LOOK_S, self._look)
        vehicle = str(self.told[Signal.DOCK_VEHICLE]) if self.told[Signal.DOCK_PERMIT] else ""
        self._dock.look(vehicle, now_s)
