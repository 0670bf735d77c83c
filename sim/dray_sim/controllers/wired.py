"""Controllers of a simulated plant, each wired to the body of each life of its agent without a network: the wire may be cut."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from enum import StrEnum
from functools import partial
from typing import Any

from dray.adapters.signals.gate import DAMAGED_SIGNALS, KeptSignals, SignalledGate
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
from dray.adapters.signals.store import DAMAGED_STORE, KeptStore, SignalledStore
from dray.adapters.signals.workcell import DAMAGED, Kept, SignalledWorkcell
from dray.messages.keys import GATE
from dray.plant import Plant
from dray.ports import Body, Clock
from dray_sim.bodies.gate import Gate
from dray_sim.bodies.stores import Storage
from dray_sim.bodies.workcell import SimWorkcell
from dray_sim.controllers.gate import ASIDE_S, GateController
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

NOTICED_S = 2.0
"""Time after which a broken wire is noticed, if nobody has cut it."""


class Moment(StrEnum):
    """A moment in which a wire breaks at its worst."""

    PERMIT = "with a permit"
    """As a permit has come to the gate's controller: it lets a container in, and the agent does not hear of it."""
    PIECE = "with a piece"
    """As a machine's agent has heard of a piece: whatever it asks for next is not heard."""


class _Life:
    """The world of a body in one life of its agent: a body whose agent has ended changes nothing any more."""

    def __init__(self, wired: Wired) -> None:
        self._wired = wired
        self.ended = False

    def remember(self, kept: Kept | KeptStore | KeptSignals) -> None:
        """Store the body's memory."""
        if not self.ended:
            self._wired.kept = kept

    def write(self) -> None:
        """Send the body's outputs."""
        if not self.ended:
            self._wired.write()


class Wired:
    """The controller of a machine, a storage or the gate, wired to the body of each life of its agent; the wire may be cut.

    Args:
        clock: the plant's.
        mapping: the controller's signals.
        damaged: the memory after unreadable data.
        make: the body of the next life, of its world, of what the last life has kept, and of the mapping.
        runs: whether the agent's process is there.

    Attributes:
        controller: to be set before the first life.
        mapping: the controller's signals, and what people have counted.
        body: that of the present life; None without one.
        kept: what the body has remembered.
        linked: whether the wire is whole.
        is_damaged: whether the next life cannot read its memory.
    """

    def __init__(
        self,
        clock: Clock,
        mapping: SignalMapping,
        damaged: Kept | KeptStore | KeptSignals,
        make: Callable[[_Life, Any, SignalMapping], SignalledWorkcell | SignalledStore | SignalledGate],
        runs: Callable[[], bool] = lambda: True,
    ) -> None:
        self._clock, self._damaged, self._make, self._runs = clock, damaged, make, runs
        self.mapping = mapping
        self.controller: MachineController | StoreController | GateController
        self.body: SignalledWorkcell | SignalledStore | SignalledGate | None = None
        self.kept: Kept | KeptStore | KeptSignals | None = None
        self.linked, self.is_damaged = True, False
        self._life = _Life(self)
        self._armed: Moment | None = None
        self._more = 0
        """Pieces that the machine begins after the break of an armed wire."""
        self._noticed, self._breaks = True, 0
        """Whether the body knows of the last break; the number of breaks, so that an outdated notice is recognised."""
        self._beats = 0
        clock.call_at(clock.now_s() + BEAT_S, self._beat)

    def live(self) -> Body:
        """The body of the next life of its agent."""
        self.end()
        if self.is_damaged:
            self.kept, self.is_damaged = self._damaged, False
        self._life = _Life(self)
        self.body = self._make(self._life, self.kept, self.mapping)
        if self.linked:
            self._begin(self.body)
        return self.body

    def end(self) -> None:
        """The agent's process is not there any more."""
        self._life.ended, self.body = True, None

    def count(self, mapping: SignalMapping, kept: KeptSignals | None) -> None:
        """People have counted, while the agent is away: its next life begins with this.

        Args:
            mapping: has what they have counted.
            kept: the memory that they leave to it.
        """
        self.end()
        self.mapping, self.kept = mapping, kept

    def write(self) -> None:
        """Send the body's outputs."""
        if not self.linked or self.body is None:
            return
        for name, value in self.body.outputs.items():
            self.controller.on_write(Signal(name), value)
            self.body.on_written(name, value)
        if self._armed is Moment.PERMIT and self.body.outputs.get(Signal.ADMITTED):
            self._break()

    # --- the wire ---

    def cut(self, more: int = 0) -> None:
        """Nothing is heard of the controller any more, and it hears nothing: `alive` stands still.

        Args:
            more: pieces that a machine still begins.
        """
        self._more = more
        self._break()
        self._notice(self._breaks)

    def cut_at(self, moment: Moment, more: int = 0) -> None:
        """Likewise, but at the next such moment; both ends notice it later."""
        self._armed, self._more = moment, more

    def link(self) -> None:
        """The controller is heard again; nothing breaks at a moment any more."""
        self._armed = None
        if self.linked:
            return
        self._notice(self._breaks)
        self.linked = True
        if self.body is not None:
            self._begin(self.body)

    def tell(self, name: str, value: Value) -> None:
        """The controller shows a value."""
        if not self.linked or self.body is None or not (name in TOLD or name.startswith(LEVEL)):
            return
        if self._armed is Moment.PIECE and name == Signal.PIECES:
            self._break()
        self.body.on_sample(name, Sample(value))

    def _begin(self, body: SignalledWorkcell | SignalledStore | SignalledGate) -> None:
        for signal, value in self.controller.shows.items():
            self.tell(signal, value)
        body.on_link()
        self.write()

    def _break(self) -> None:
        self.linked, self._noticed, self._armed = False, False, None
        self._breaks += 1
        self._stop(self._more)
        self._clock.call_at(self._clock.now_s() + NOTICED_S, partial(self._notice, self._breaks))

    def _notice(self, number: int) -> None:
        if number != self._breaks or self._noticed:
            return
        self._noticed = True
        if self.body is not None:
            self.body.on_link_lost("cut")

    def _stop(self, more: int = 0) -> None:
        if isinstance(self.controller, MachineController):
            self.controller.miss_alive(more)

    def _beat(self) -> None:
        self._clock.call_at(self._clock.now_s() + BEAT_S, self._beat)
        if self.body is not None and not self._runs():
            self.end()
            self._stop()
        if self.linked and self.body is not None:
            self._beats += 1
            self.controller.on_write(Signal.ALIVE, self._beats)


class WiredBodies(Bodies):
    """All machines, stores and the gate of a plant with their controllers, and the bodies of their agents.

    Args:
        plant: its machines and stores.
        clock: the plant's.
        modulus: at which the counters of machines roll over.
        aside_s: time after which the gate puts a container aside that is not admitted.

    Attributes:
        wired: by agent, once it has lived.
        runs: whether an agent's process is there; without it nobody hears its controller.
    """

    has_levels = True

    def __init__(
        self, plant: Plant, clock: Clock, *, modulus: int = MODULUS, aside_s: float = ASIDE_S
    ) -> None:
        self._plant, self._clock, self._modulus, self._aside_s = plant, clock, modulus, aside_s
        self.wired: dict[str, Wired] = {}
        self.runs: Callable[[str], bool] = lambda _agent: True

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
        plant, clock, spec = self._plant, self._clock, self._plant.machines[workcell.id]
        wired = Wired(
            clock,
            SignalMapping(tags, workcell.sense().stock),
            DAMAGED,
            lambda life, kept, mapping: SignalledWorkcell(spec, plant, mapping, clock, life, kept),
            lambda: self.runs(workcell.id),
        )
        wired.controller = MachineController(workcell, clock, wired.tell, modulus=self._modulus)
        return wired

    def _store(self, storage: Storage) -> Wired:
        """With a scale for each material."""
        tags = {signal: Tag(signal.value) for signal in AT_A_DOCK}
        levels = {item: Tag(item) for item in storage.stock}
        clock, spec = self._clock, self._plant.stores[storage.id]
        wired = Wired(
            clock,
            SignalMapping(tags, dict(storage.stock), levels),
            DAMAGED_STORE,
            lambda life, kept, mapping: SignalledStore(spec, mapping, clock, life, kept),
            lambda: self.runs(storage.id),
        )
        wired.controller = StoreController(storage, clock, wired.tell)
        return wired

    def _gate(self, gate: Gate) -> Wired:
        """With a reader of labels, and a counter."""
        clock = self._clock
        wired = Wired(
            clock,
            SignalMapping({signal: Tag(signal.value) for signal in (Signal.PIECES, *OF_A_GATE)}),
            DAMAGED_SIGNALS,
            lambda life, kept, mapping: SignalledGate(mapping, clock, life, kept),
            lambda: self.runs(GATE),
        )
        wired.controller = GateController(gate, clock, wired.tell, aside_s=self._aside_s)
        return wired
