"""A machine's body: buffers of material, a cycle, finished goods, and a dock for vehicles.

It follows instructions and decides nothing. A cycle takes its whole bill out of the buffers when it starts and puts
one piece into the goods when it ends. Vehicles load and unload only where the dock was opened for them; the rest of
the negotiation is the agent's (`dray.protocol.machine.machine`).

Pieces that came in = buffers + consumed; pieces that were made = goods + taken away. Both are counted,
so that material can be balanced (invariant 2).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from random import Random

from dray.body import (
    Book,
    Broken,
    CloseDock,
    CycleDone,
    CycleFailed,
    Instruction,
    OpenDock,
    ReadDocument,
    Repaired,
    Report,
    ResetFault,
    SetPace,
    StartCycle,
    StockChanged,
    WorkcellState,
)
from dray.body.documents import Documents
from dray.messages import NOTHING_KNOWN, THING, Problem
from dray.plant import Plant
from dray.plant.model import MachineSpec
from dray.ports import Clock
from dray_sim.bodies.docks import OpenDocks
from dray_sim.bodies.documents import SimDocuments
from dray_sim.bodies.durations import Durations
from dray_sim.bodies.reporter import Reporter
from dray_sim.bodies.stores import NO_ROOM, NOT_KEPT, TOO_LITTLE

NO_POWER = "no power"


@dataclass(frozen=True, slots=True)
class WorkcellTimes:
    """How a workcell's time was spent; the body cannot know why it is not cycling."""

    cycling_s: float
    broken_s: float
    """Without power, too."""
    still_s: float


@dataclass(slots=True)
class _Cycle:
    """A piece in the making."""

    product: str
    left_s: float
    """Remaining time as of the last settling; it stands still while the machine is broken or without power."""


class SimWorkcell:
    """Implements `dray.ports.Body` and `dray_sim.bodies.stores.Place`.

    Invariants: no stock is negative or above its capacity; a running cycle has room for its piece.

    Args:
        spec: the machine.
        plant: for bills of material and sizes of buffers.
        clock: the plant's clock.
        stock: pieces of materials and products at the beginning.
        seed: how long each cycle takes follows from it, where that varies.

    Attributes:
        id: the machine's id.
        consumed: pieces of every material that cycles have taken.
        made: good pieces of every product that cycles have put out.
        scrapped: bad ones.
        things: things without master data that were brought here, less those that were fetched; the number at the
            beginning is unknown.
        documents: its document store.
    """

    def __init__(
        self,
        spec: MachineSpec,
        plant: Plant,
        clock: Clock,
        stock: Mapping[str, int] | None = None,
        seed: int = 0,
    ) -> None:
        self.id = spec.id
        self._plant = plant
        self.consumed: Counter[str] = Counter()
        self.made: Counter[str] = Counter()
        self.scrapped: Counter[str] = Counter()
        self._clock = clock
        self._reporter = Reporter(clock)
        self.documents: Documents = SimDocuments(clock)
        self._cycle_s = {making.product: making.cycle_s for making in spec.makes}
        self._cycle_cv = {making.product: making.cycle_cv for making in spec.makes}
        self._scrap_frac = {making.product: making.scrap_frac for making in spec.makes if making.scrap_frac}
        self._chance = Random(f"{seed} scrap {spec.id}")
        self._durations = Durations(f"{seed} cycles {spec.id}")
        self._bills = {
            product: {line.material: line.quantity for line in plant.products[product].bill}
            for product in self._cycle_s
        }
        materials = plant.materials_of(spec.id)
        self._buffers = {material: plant.materials[material].buffer for material in materials}
        self._goods_capacity = spec.goods_capacity
        self._stock = dict.fromkeys((*materials, *self._cycle_s), 0) | dict(stock or {})
        self.things = 0
        self._counts = spec.counts
        self._unbooked: Counter[str] = Counter()
        """Pieces that lie there unknown to a body that does not count; below 0 for pieces that it wrongly believes to
        be there."""
        self._seq = 0
        """Number of the last change of the stock that a report tells of."""
        self._docks = OpenDocks()
        self._cycle: _Cycle | None = None
        self._broken = ""
        self._about = NOTHING_KNOWN
        self._resettable = False
        """The fault is repaired, and the machine has not been reset yet."""
        self._speed_frac = 1.0
        self._off = False
        self._turn = 0
        """Grows when a cycle's end moves, so that an outdated call of the clock is recognised."""
        self._since_s = self._began_s = clock.now_s()
        self._cycling_s = self._broken_s = 0.0

    # --- Body ------------------------------------------------------------------------------------

    def instruct(self, instruction: Instruction) -> None:
        """See `dray.ports.Body`. Instructions for vehicles are ignored: no report would fit them.

        Without power nothing is heard.
        """
        if self._off:
            return
        if isinstance(instruction, StartCycle):
            self._start(instruction)
        elif isinstance(instruction, OpenDock):
            self._provide(instruction.item)
            self._docks.open(instruction.vehicle, instruction.item, instruction.quantity)
        elif isinstance(instruction, CloseDock):
            self._docks.shut(instruction.vehicle)
        elif isinstance(instruction, ResetFault):
            if self._resettable:
                self.repair()
        elif isinstance(instruction, SetPace):
            self._speed_frac = instruction.speed_frac
        elif isinstance(instruction, ReadDocument):
            self.documents.read(instruction.document, self._tell)
        elif isinstance(instruction, Book) and instruction.item in (THING, *self._stock) and not self._counts:
            self._unbooked[instruction.item] -= instruction.change
            self._tell_change(instruction.item, instruction.change, instruction.vehicle)
        self._reporter.flush_soon()

    def sense(self) -> WorkcellState:
        """See `dray.ports.Body`."""
        cycling = self._cycle.product if self._cycle is not None else ""
        stock = dict(self._stock)
        for item, pieces in self._unbooked.items():
            if item != THING:
                stock[item] -= pieces
        return WorkcellState(
            stock=stock,
            seq=self._seq,
            cycling=cycling,
            broken=self._broken,
            counts=self._counts,
            about_problem=self._about,
            resettable=self._resettable,
            paces=True,
        )

    def uncounted(self, item: str) -> int:
        """Pieces that lie here unknown to a body that does not count."""
        return self._unbooked[item]

    def attach(self, report: Callable[[Report], None]) -> None:
        """See `dray.ports.Body`."""
        self._reporter.attach(report)

    # --- Place -----------------------------------------------------------------------------------

    def take(self, vehicle: str, item: str, quantity: int) -> str:
        """See `Place`. A vehicle takes only the load for which the dock is open."""
        reason = self._refusal(vehicle, item, quantity)
        if reason:
            return reason
        if shut := self._docks.refusal(vehicle, item, quantity):
            return shut
        if item != THING and self._stock[item] < quantity:
            return TOO_LITTLE
        self._transfer(vehicle, item, -quantity)
        return ""

    def put(self, vehicle: str, item: str, quantity: int, goal: str = "") -> str:
        """See `Place`. A vehicle puts down only the load for which the dock is open; goods may come back, too."""
        reason = self._refusal(vehicle, item, quantity)
        if reason:
            return reason
        if item != THING and quantity > self.room(item):
            return NO_ROOM
        self._transfer(vehicle, item, quantity)
        return ""

    def room(self, item: str) -> int:
        """How many more pieces of a material or product fit in; a piece in the making has its place."""
        if item in self._buffers:
            return self._buffers[item] - self._stock[item]
        if item in self._cycle_s:
            goods = sum(self._stock[product] for product in self._cycle_s)
            return self._goods_capacity - goods - (self._cycle is not None)
        return 0

    def _provide(self, item: str) -> None:
        """Make a buffer for a material that is brought for the first time: each machine has room for all."""
        if item in self._plant.materials and item not in self._stock:
            self._buffers[item] = self._plant.materials[item].buffer
            self._stock[item] = 0

    # --- the world -------------------------------------------------------------------------------

    @property
    def broken(self) -> str:
        """Why it stands; empty when it works."""
        return self._broken

    def break_down(self, reason: str, problem: Problem = NOTHING_KNOWN) -> None:
        """Stop; a running cycle pauses. A machine that is broken already keeps its first reason."""
        if self._broken and not self._resettable:
            return
        self._settle()
        self._broken, self._about, self._resettable = reason, problem, False
        self._reporter.say(Broken(reason=reason, problem=problem))
        self._change_of_fortune()

    def mend(self) -> None:
        """Repair a fault: the machine stands until it is reset. Harmless when nothing is broken."""
        if self._broken and not self._resettable:
            self._resettable = True
            self._reporter.say(Broken(reason=self._broken, problem=self._about, resettable=True))
            self._reporter.flush_soon()

    def repair(self) -> None:
        """Work again; harmless when nothing is broken."""
        if not self._broken:
            return
        self._settle()
        self._broken, self._about, self._resettable = "", NOTHING_KNOWN, False
        self._reporter.say(Repaired())
        self._change_of_fortune()

    @property
    def off(self) -> bool:
        """Whether it has no power."""
        return self._off

    def power_off(self) -> None:
        """Stop, deaf and mute; harmless when it is off already. A running cycle pauses, the dock shuts."""
        if self._off:
            return
        self._settle()
        self._off = True
        self._docks.shut_all()
        self._reporter.mute()
        self._change_of_fortune()

    def power_on(self) -> None:
        """Work again: a paused cycle goes on, the dock stays shut. Harmless when it is on."""
        if not self._off:
            return
        self._settle()
        self._off = False
        self._reporter.unmute()
        self._change_of_fortune()

    def put_by_hand(self, item: str, quantity: int) -> str:
        """A person puts pieces in, past the dock. Returns "" when they are in, else why not."""
        if item not in self._stock:
            return NOT_KEPT
        if quantity > self.room(item):
            return NO_ROOM
        self._change_stock(item, quantity)
        return ""

    def times(self) -> WorkcellTimes:
        """How the time from the beginning until now was spent."""
        now_s = self._clock.now_s()
        since_s = now_s - self._since_s
        broken_s = self._broken_s + (since_s if self._stands else 0.0)
        cycling = self._cycle is not None and not self._stands
        cycling_s = self._cycling_s + (since_s if cycling else 0.0)
        return WorkcellTimes(cycling_s, broken_s, now_s - self._began_s - broken_s - cycling_s)

    # --- how it is done --------------------------------------------------------------------------

    @property
    def _stands(self) -> bool:
        return bool(self._broken) or self._off

    def _change_of_fortune(self) -> None:
        """Something outside has changed: let the cycle go on or pause, and tell."""
        self._turn += 1
        if self._cycle is not None and not self._stands:
            self._schedule(self._cycle)
        self._reporter.flush_soon()

    def _start(self, start: StartCycle) -> None:
        product = start.product
        if start.cycle_s > 0.0 and product not in self._cycle_s and product not in self._plant.materials:
            # A machine that was not set up for a product is told the time of a piece.
            self._cycle_s[product], self._cycle_cv[product] = start.cycle_s, 0.0
            self._stock.setdefault(product, 0)
        bill = {line.material: line.quantity for line in start.bill} or self._bills.get(product, {})
        for material in bill:
            self._provide(material)
        reason = self._why_not(product, bill)
        if reason:
            self._reporter.say(CycleFailed(product=product, reason=reason))
            return
        self._settle()
        for material, quantity in bill.items():
            self._stock[material] -= quantity
            self.consumed[material] += quantity
        cycle_s = self._durations.draw_s(self._cycle_s[product], self._cycle_cv[product])
        self._cycle = _Cycle(product, cycle_s / self._speed_frac)
        self._schedule(self._cycle)

    def _why_not(self, product: str, bill: Mapping[str, int]) -> str:
        """Why a cycle cannot start; empty when it can."""
        if product not in self._cycle_s:
            return "not made here"
        if self._broken:
            return self._broken
        if self._cycle is not None:
            return f"busy with {self._cycle.product}"
        if self.room(product) < 1:
            return "no room for the piece"
        missing = [material for material, quantity in bill.items() if self._stock.get(material, 0) < quantity]
        for material in missing:
            del self._unbooked[material]  # A person who reaches for a piece sees the true stock.
        return f"missing {', '.join(missing)}" if missing else ""

    def _schedule(self, cycle: _Cycle) -> None:
        self._turn += 1
        self._clock.call_at(self._since_s + cycle.left_s, partial(self._finish, self._turn))

    def _finish(self, turn: int) -> None:
        if turn != self._turn or self._cycle is None:
            return
        self._settle()
        product, self._cycle = self._cycle.product, None
        bad = product in self._scrap_frac and self._chance.random() < self._scrap_frac[product]
        self._seq += 1
        self._stock[product] += not bad
        (self.scrapped if bad else self.made)[product] += 1
        self._reporter.say(CycleDone(product=product, seq=self._seq, bad=bad))
        self._reporter.flush()

    def _refusal(self, vehicle: str, item: str, quantity: int) -> str:
        if self._off:
            return NO_POWER
        # Less may come than the dock was opened for: the dock counts it.
        if shut := self._docks.refusal_of_part(vehicle, item, quantity):
            return shut
        self._provide(item)  # A dock that accepts any load was not told the item.
        return "" if item in (THING, *self._stock) else NOT_KEPT

    def _transfer(self, vehicle: str, item: str, change: int) -> None:
        self._docks.shut(vehicle)
        self._change_stock(item, change, vehicle)

    def _change_stock(self, item: str, change: int, vehicle: str = "") -> None:
        if item == THING:
            self.things += change
        else:
            self._stock[item] += change
        if vehicle and not self._counts:
            self._unbooked[item] += change
        else:
            self._tell_change(item, change, vehicle)

    def _tell_change(self, item: str, change: int, vehicle: str) -> None:
        self._seq += 1
        self._reporter.say(StockChanged(item=item, change=change, seq=self._seq, vehicle=vehicle))
        self._reporter.flush_soon()

    def _tell(self, report: Report) -> None:
        self._reporter.say(report)
        self._reporter.flush_soon()

    def _settle(self) -> None:
        """Bring the sums of time up to now."""
        now_s = self._clock.now_s()
        passed_s, self._since_s = now_s - self._since_s, now_s
        if self._stands:
            self._broken_s += passed_s
        elif self._cycle is not None:
            self._cycling_s += passed_s
            self._cycle.left_s -= passed_s
