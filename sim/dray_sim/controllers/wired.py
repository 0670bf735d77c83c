"""Controllers of a simulated plant, each wired to the body of each life of its agent without a network: the wire may be cut."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from dray.adapters.signals.gate import KeptSignals, SignalledGate
from dray.adapters.signals.signal import (
    AT_A_DOCK,
    LEVEL,
    OF_A_GATE,
    Sample,
    Signal,
    SignalMapping,
    Tag,
    Value,
)
from dray.adapters.signals.store import KeptStore, SignalledStore
from dray.adapters.signals.workcell import Kept, SignalledWorkcell
from dray.messages.keys import GATE
from dray.plant import Plant
from dray.ports import Body, Clock
from dray_sim.bodies.gate import Gate
from dray_sim.bodies.stores import Storage
from dray_sim.bodies.workcell import SimWorkcell
from dray_sim.controllers.gate import GateController
from dray_sim.controllers.machine import COUNTERS, MODULUS, MachineController
from dray_sim.controllers.store import StoreController
from dray_sim.factory.installation import Bodies

SIGNALS = (
    *(Signal.PIECES, Signal.BAD, Signal.FAULT, Signal.DOCK_READY),
    *(Signal.RUN, Signal.PRODUCT, Signal.DOCK_PERMIT, Signal.DOCK_VEHICLE),
)
"""Signals of a machine."""

TOLD = (*SIGNALS, Signal.GOAL)
"""Signals that a controller may tell, beside levels."""

BEAT_S = 1.0
"""Time between two values of `alive`, which a link writes while it is there."""


class Wired:
    """The controller of a machine, a storage or the gate, wired to the body of each life of its agent; the wire may be cut.

    Args:
        clock: the plant's.
        make: the body of the next life, of its world and of what the last life has kept.

    Attributes:
        controller: to be set before the first life.
        body: that of the present life; None before the first one.
        kept: what the body has remembered.
        linked: whether the wire is whole.
    """

    def __init__(
        self, clock: Clock, make: Callable[[Wired, Any], SignalledWorkcell | SignalledStore | SignalledGate]
    ) -> None:
        self._clock, self._make = clock, make
        self.controller: MachineController | StoreController | GateController
        self.body: SignalledWorkcell | SignalledStore | SignalledGate | None = None
        self.kept: Kept | KeptStore | KeptSignals | None = None
        self.linked = True
        self._beats = 0
        clock.call_at(clock.now_s() + BEAT_S, self._beat)

    def live(self) -> Body:
        """The body of the next life of its agent."""
        self.body = self._make(self, self.kept)
        if self.linked:
            self.link()
        return self.body

    # --- the body's world ---

    def remember(self, kept: Kept | KeptStore | KeptSignals) -> None:
        """Store the body's memory."""
        self.kept = kept

    def write(self) -> None:
        """Send the body's outputs."""
        if self.linked and self.body is not None:
            for name, value in self.body.outputs.items():
                self.controller.on_write(Signal(name), value)

    # --- the wire ---

    def cut(self) -> None:
        """Nothing is heard of the controller any more, and it hears nothing: `alive` stands still, so it begins no other piece."""
        self.linked = False
        self.controller.on_write(Signal.RUN, False)
        if self.body is not None:
            self.body.on_link_lost("cut")

    def link(self) -> None:
        """The controller is heard again."""
        self.linked = True
        if self.body is not None:
            for signal, value in self.controller.shows.items():
                self.tell(signal, value)
            self.body.on_link()
            self.write()

    def tell(self, name: str, value: Value) -> None:
        """The controller shows a value."""
        if self.linked and self.body is not None and (name in TOLD or name.startswith(LEVEL)):
            self.body.on_sample(name, Sample(value))

    def _beat(self) -> None:
        self._clock.call_at(self._clock.now_s() + BEAT_S, self._beat)
        if self.linked and self.body is not None:
            self._beats += 1
            self.controller.on_write(Signal.ALIVE, self._beats)


class WiredBodies(Bodies):
    """All machines, stores and the gate of a plant with their controllers, and the bodies of their agents.

    Args:
        plant: its machines and stores.
        clock: the plant's.
        modulus: at which the counters of machines roll over.

    Attributes:
        wired: by agent, once it has lived.
    """

    has_levels = True

    def __init__(self, plant: Plant, clock: Clock, *, modulus: int = MODULUS) -> None:
        self._plant, self._clock, self._modulus = plant, clock, modulus
        self.wired: dict[str, Wired] = {}

    def embody_machine(self, workcell: SimWorkcell, _life: int) -> Body:
        """The body of the next life of a machine's agent."""
        return self._live(workcell.id, lambda: self._machine(workcell))

    def embody_store(self, storage: Storage, _life: int) -> Body:
        """The body of the next life of a station."""
        return self._live(storage.id, lambda: self._store(storage))

    def embody_gate(self, gate: Gate, _life: int) -> Body:
        """The body of the next life of the gate."""
        return self._live(GATE, lambda: self._gate(gate))

    def arrived(self, goal: str) -> int:
        """Pieces of a goal that the gate's controller has let in."""
        gate = self.wired.get(GATE)
        return gate.controller.let_in[goal] if gate and isinstance(gate.controller, GateController) else 0

    def doubts(self) -> Mapping[str, str]:
        """Why counts of machines and the gate are in doubt, by agent."""
        return {
            name: wired.kept.doubt
            for name, wired in self.wired.items()
            if isinstance(wired.kept, Kept | KeptSignals) and wired.kept.doubt
        }

    def _live(self, agent: str, build: Callable[[], Wired]) -> Body:
        if agent not in self.wired:
            self.wired[agent] = build()
        return self.wired[agent].live()

    def _machine(self, workcell: SimWorkcell) -> Wired:
        tags = {signal: Tag(signal.value) for signal in SIGNALS}
        for signal in COUNTERS:
            tags[signal] = Tag(signal.value, rolls_over_at=self._modulus)
        mapping, spec = SignalMapping(tags, workcell.sense().stock), self._plant.machines[workcell.id]
        plant, clock = self._plant, self._clock
        wired = Wired(clock, lambda world, kept: SignalledWorkcell(spec, plant, mapping, clock, world, kept))
        wired.controller = MachineController(workcell, clock, wired.tell, modulus=self._modulus)
        return wired

    def _store(self, storage: Storage) -> Wired:
        """With a scale for each material."""
        tags = {signal: Tag(signal.value) for signal in AT_A_DOCK}
        levels = {item: Tag(item) for item in storage.stock}
        mapping, spec = SignalMapping(tags, dict(storage.stock), levels), self._plant.stores[storage.id]
        clock = self._clock
        wired = Wired(clock, lambda world, kept: SignalledStore(spec, mapping, clock, world, kept))
        wired.controller = StoreController(storage, clock, wired.tell)
        return wired

    def _gate(self, gate: Gate) -> Wired:
        """With a reader of labels, and a counter."""
        mapping = SignalMapping({signal: Tag(signal.value) for signal in (Signal.PIECES, *OF_A_GATE)})
        clock = self._clock
        wired = Wired(clock, lambda world, kept: SignalledGate(mapping, clock, world, kept))
        wired.controller = GateController(gate, clock, wired.tell)
        return wired
