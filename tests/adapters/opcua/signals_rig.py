"""A machine's body with a clock, a disk and a link that are turned by hand."""

from __future__ import annotations

from collections.abc import Callable

from dray.adapters.signals.signal import Edge, Quality, Sample, Signal, SignalMapping, Tag, Value
from dray.adapters.signals.workcell import Kept, SignalledWorkcell
from dray.body import Report, StartCycle, WorkcellState
from dray.plant import default_plant

PLANT = default_plant()
SPEC = PLANT.machines["M1"]
PRODUCT = SPEC.makes[0].product
CYCLE_S = min(making.cycle_s for making in SPEC.makes)
BILL = {line.material: line.quantity for line in PLANT.products[PRODUCT].bill}
ITEM = next(iter(BILL))
OTHER = next(making.product for making in SPEC.makes if making.product != PRODUCT)
ALL = {line.material: 100 for making in SPEC.makes for line in PLANT.products[making.product].bill}
"""Material for either product."""

COUNTER = {Signal.PIECES: Tag("pieces")}
TWO_BITS = {
    **COUNTER,
    Signal.FAULT: Tag("fault"),
    Signal.RUN: Tag("run"),
    Signal.DOCK_PERMIT: Tag("permit"),
    Signal.DOCK_READY: Tag("ready"),
    Signal.DOCK_VEHICLE: Tag("vehicle"),
}
PULSE = {Signal.PIECES: Tag("pulse", edge=Edge.RISING)}
PLENTY = dict.fromkeys(BILL, 100)


class HandClock:
    """Implements `dray.ports.Clock`."""

    def __init__(self) -> None:
        self._now_s = 1_000.0
        self._calls: list[tuple[float, Callable[[], None]]] = []

    def now_s(self) -> float:
        return self._now_s

    def call_at(self, when_s: float, callback: Callable[[], None]) -> None:
        self._calls.append((when_s, callback))

    def pass_s(self, span_s: float) -> None:
        """Let time pass; what was to be called is."""
        until_s = self._now_s + span_s
        while due := sorted((call for call in self._calls if call[0] <= until_s), key=lambda call: call[0]):
            self._calls.remove(due[0])
            self._now_s = max(self._now_s, due[0][0])
            due[0][1]()
        self._now_s = until_s


class Rig:
    """One machine, over several lives of its agent.

    Args:
        signals: what its controller has.
        stock: pieces at the beginning.
        linked: whether the controller is there at once.
    """

    def __init__(
        self,
        signals: dict[Signal, Tag] | None = None,
        stock: dict[str, int] | None = None,
        *,
        linked: bool = True,
    ) -> None:
        self.mapping = SignalMapping(signals or COUNTER, PLENTY if stock is None else stock)
        self.clock, self.kept, self.reports = HandClock(), None, list[Report]()
        self.writes, self.broker = 0, ""
        self.begin()
        if linked:
            self.tell(Signal.PIECES, 0)
            self.body.on_link()
            self.reports.clear()

    def begin(self) -> None:
        """Another life of its agent: of the last one only what was remembered is left."""
        self.body = SignalledWorkcell(
            SPEC, PLANT, self.mapping, self.clock, self, self.kept, broker=self.broker
        )
        self.body.attach(self.reports.append)

    # --- a world ---

    kept: Kept | None

    def remember(self, kept: Kept) -> None:
        self.kept = kept

    def write(self) -> None:
        self.writes += 1

    # --- what tests say and see ---

    def tell(self, signal: Signal, value: Value, quality: Quality = Quality.GOOD, reason: str = "") -> None:
        self.body.on_sample(signal, Sample(value, quality, reason))

    def confirm(self, signal: Signal) -> None:
        """The controller has this output as it is now."""
        self.body.on_written(signal, self.body.outputs[signal])

    def start(self, product: str = PRODUCT) -> None:
        self.body.instruct(StartCycle(product=product))

    @property
    def state(self) -> WorkcellState:
        return self.body.sense()

    def heard(self) -> list[Report]:
        """What was reported since this was asked last."""
        heard, self.reports[:] = list(self.reports), []
        return heard
