"""The body of a machine with single-value signals of a controller.

The controller counts the pieces. The stock of the buffers follows from vehicles' reports of transfers, and from the bills of
material of pieces made. Each change is stored before it is reported, so a life that follows a kill finds it in the stock.

A machine may make one piece after the other without an instruction for each: such a piece counts, too, and uses its material.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Protocol

from msgspec import Struct
from msgspec.structs import replace

from dray.adapters.signals.counting import CounterState, Reading, count, count_pulse, doubt_of_another
from dray.adapters.signals.dock import DockHandshake, DockState
from dray.adapters.signals.signal import (
    Quality,
    Sample,
    Signal,
    SignalMapping,
    Tag,
    Value,
    brief,
    fault_words,
    quoted,
)
from dray.adapters.vehicles_words import name_of, with_word
from dray.body import (
    Book,
    Broken,
    CloseDock,
    CycleDone,
    CycleFailed,
    DockReady,
    Instruction,
    OpenDock,
    Repaired,
    Report,
    ResetFault,
    SetPace,
    StartCycle,
    StockChanged,
    WorkcellState,
)
from dray.messages import NOTHING_KNOWN, THING, Problem, ProblemKind
from dray.messages.base import COUNT_MAX
from dray.plant import Plant
from dray.plant.model import MachineSpec
from dray.ports import Clock, nobody_hears

LATE_CYCLES, LATE_MIN_S = 5.0, 60.0
"""A missing piece is reported after this number of cycle times, but not earlier than these seconds."""

HELD_CYCLES = 2.0
"""Cycle times for which another product waits after a broken connection. A controller that keeps `run` meanwhile makes another piece of the
last product. It ends within one cycle; the rest is for cycles that take longer than the plant file says."""

UNSURE = "grew after a broken connection"
"""Why a count is in doubt that may be of either of two products."""

STANDS = {
    "notavailable": "not available",
    "outofservice": "out of service",
    0: "not available",
    1: "out of service",
}
"""Words and numbers of a machine's state for not working (OPC 40001-1, MachineryItemState)."""
WORKS = frozenset({"notexecuting", "executing", 2, 3})
"""Those for working, or being able to."""

_NO_LINK = Problem(kind=ProblemKind.LINK, passes=True)
_SOFTWARE = Problem(kind=ProblemKind.SOFTWARE, needs_person=True)


class Kept(Struct, frozen=True):
    """A machine's memory for the agent's next life."""

    stock: dict[str, int]
    seq: int = 0
    pieces: CounterState | None = None
    bad: CounterState | None = None
    cycling: str = ""
    last: str = ""
    """The product last asked for: pieces made without an instruction count as this."""
    held: str = ""
    """The product that may still come, while `cycling` waits for its end after a broken connection; empty for none. `cycling` has used no
    material yet."""
    unsure: bool = False
    """Whether it may be `cycling` that still comes: it was asked for, and nobody knows whether the controller has heard that."""
    confirmed: str = ""
    """The product that the controller has confirmed last; empty for none, and by MQTT, which confirms nothing."""
    confirmed_at: str = ""
    """Where it was confirmed: the source of `product` in the mapping of that time."""
    doubt: str = ""
    """Why counts may be wrong, until a person has checked them."""
    opened: tuple[str, ...] = ()
    """Vehicles for which the dock is open or opening, in order."""
    let_in: OpenDock | None = None
    """Which of them was let in, and to move what."""
    booked: dict[str, int] = {}
    """The vehicles' latest reports (`dray.body.Book`), each with the number of its stock change: a restarted agent repeats them."""


DAMAGED = Kept({}, doubt="what was remembered of it is damaged; see what lies in its buffers")
"""The memory after unreadable data."""


class World(Protocol):
    """The surroundings of the body, beside its clock."""

    def remember(self, kept: Kept) -> None:
        """Store the memory: on the disk at the return."""

    def write(self) -> None:
        """The body's `outputs` have changed: send them to the controller."""


class SignalledWorkcell:
    """Implements `dray.ports.Body`, and the listener of a link to a controller.

    Args:
        spec: the machine.
        plant: for bills of material.
        mapping: its controller's signals.
        clock: the plant's.
        world: the disk and the link.
        kept: the last life's memory; None for the first one.
        broker: the address of its controller's broker; empty by OPC UA.

    Attributes:
        outputs: the wanted outputs, by signal; a link writes the differences.
    """

    def __init__(
        self,
        spec: MachineSpec,
        plant: Plant,
        mapping: SignalMapping,
        clock: Clock,
        world: World,
        kept: Kept | None = None,
        *,
        broker: str = "",
    ) -> None:
        self._broker = broker
        self._mapping, self._tags, self._clock, self._world = mapping, mapping.signals, clock, world
        self._moduli: dict[Signal, tuple[int, ...]] = {
            signal: (tag.rolls_over_at,)
            for signal, tag in self._tags.items()
            if tag.rolls_over_at is not None
        }
        self._cycle_s = {making.product: making.cycle_s for making in spec.makes}
        self._bills = {
            product: {line.material: line.quantity for line in plant.products[product].bill}
            for product in self._cycle_s
        }
        items = (*plant.materials_of(spec.id), *self._cycle_s)
        self._kept = kept or Kept(dict.fromkeys(items, 0) | mapping.stock, last=spec.makes[0].product)
        if not self._kept.last:
            self._kept = replace(self._kept, last=spec.makes[0].product)
        self._stock = dict.fromkeys(items, 0) | self._kept.stock
        self._report: Callable[[Report], None] = nobody_hears
        self._dock = DockHandshake(answers=Signal.DOCK_READY in self._tags)
        self._loads: dict[str, OpenDock] = {}
        """By vehicle: what it may move once it is let in, where this life was told."""
        self._told_ready = ""
        """The vehicle that was reported as let in, so that it is reported once."""
        self._away = "nothing was heard of its controller yet"
        """The reason why the controller is not connected; empty while it is."""
        self._gaps = {Signal.PIECES, Signal.BAD}
        """Counts whose values may have been missed since the last one."""
        self._has_worked, self._held_until_s = kept is not None, -math.inf
        """Whether the controller may have made pieces without a connection; until when another product waits."""
        self._silent: dict[Signal, str] = {}
        """Signals with invalid values, with the reason."""
        self._refused: dict[Signal, str] = {}
        """Signals that the controller refuses."""
        self._fault, self._fault_text, self._standing = "", "", ""
        self._resets = False
        """Whether the controller is told to clear its fault."""
        self._late = ""
        self._turn = 0
        """Number of pieces waited for, so that an outdated call of the clock is recognised."""
        self._told: tuple[str, Problem, bool] = ("", NOTHING_KNOWN, False)
        self.outputs: dict[str, Value] = {}
        # A vehicle at the dock keeps its permit, without interruption.
        for vehicle in self._kept.opened:
            self._dock.want(vehicle)
        self._hold_unconfirmed()
        if self._kept.confirmed_at != self._product_at:
            # Another controller has confirmed it, or another node: the present one may make something else.
            self._kept = replace(self._kept, confirmed="")
        # A piece begun in an earlier life is still wanted.
        wanted = "" if self._kept.held else self._kept.cycling
        self._put(Signal.PRODUCT, wanted)
        self._put(Signal.RUN, bool(wanted))
        self._put(Signal.DOCK_PERMIT, bool(self._dock.vehicle))
        self._put(Signal.DOCK_VEHICLE, self._dock.vehicle)
        self._judge()
        if wanted:
            self._expect(wanted)

    # --- Body ---

    def instruct(self, instruction: Instruction) -> None:
        """See `dray.ports.Body`. Instructions that a machine cannot follow are ignored."""
        match instruction:
            case StartCycle():
                self._start(instruction)
            case OpenDock(vehicle=vehicle):
                self._loads[vehicle] = instruction
                self._told_ready = "" if self._told_ready == vehicle else self._told_ready
                self._dock.want(vehicle)
            case CloseDock(vehicle=vehicle):
                self._loads.pop(vehicle, None)
                self._dock.done(vehicle)
            case Book():
                self._dock.done(instruction.vehicle)
                self._move(instruction)
            case ResetFault():
                self._reset()
            case SetPace(speed_frac=speed_frac):
                self._put(Signal.SPEED, speed_frac * self._scale(Signal.SPEED))
            case _:
                return
        if self._dock.waiting != self._kept.opened:
            self._keep()
        self._settle()

    def sense(self) -> WorkcellState:
        """See `dray.ports.Body`."""
        broken, problem, resettable = self._told
        return WorkcellState(
            stock=dict(self._stock),
            seq=self._kept.seq,
            cycling=self._kept.cycling,
            broken=broken,
            counts=False,
            about_problem=problem,
            resettable=resettable,
            paces=Signal.SPEED in self._tags,
            answers=True,
            opened=self._dock.waiting,
            let_in=self._kept.let_in,
        )

    def attach(self, report: Callable[[Report], None]) -> None:
        """See `dray.ports.Body`."""
        self._report = report

    @property
    def is_dock_shut(self) -> bool:
        """Whether no vehicle is let in, and the controller works."""
        return self._dock.state is DockState.SHUT

    # --- the listener of a link ---

    def on_link(self) -> None:
        """The controller is connected, and its values come."""
        self._away = ""
        if self._has_worked:
            may_come = (self._kept.held or self._kept.last, self._kept.cycling if self._kept.unsure else "")
            cycle_s = max(self._cycle_s.get(product, 0.0) for product in may_come)
            self._held_until_s = self._clock.now_s() + HELD_CYCLES * cycle_s
            self._wait()
        self._has_worked = True
        self._settle()

    def on_link_lost(self, reason: str) -> None:
        """The connection to the controller is lost."""
        self._away = reason
        self._gaps = {Signal.PIECES, Signal.BAD}
        self._silent.clear()
        self._dock.lost()
        if self._hold_unconfirmed():
            self._put(Signal.RUN, False)
        self._settle()

    def on_range(self, signal: str, moduli: tuple[int, ...]) -> None:
        """The controller has sent where a counter may roll over; the mapping takes precedence."""
        if self._tags[Signal(signal)].rolls_over_at is None:
            self._moduli[Signal(signal)] = moduli

    def on_sample(self, name: str, sample: Sample) -> None:
        """The controller has sent a value."""
        signal = Signal(name)
        value = sample.value if sample.quality is Quality.GOOD else None
        understood = None if value is None else self._take(signal, value)
        if value is None:
            self._silent[signal] = sample.reason or f"it is {sample.quality.value}"
        elif understood is not None:
            self._silent[signal] = brief(understood)
        else:
            self._silent.pop(signal, None)
        if signal in self._silent and signal in (Signal.PIECES, Signal.BAD):
            self._gaps.add(signal)
        if signal is Signal.DOCK_READY and signal in self._silent:
            self._dock.lost()
        self._settle()

    def on_refused(self, name: str, reason: str) -> None:
        """The controller refuses a value; without a reason it accepts it again."""
        signal = Signal(name)
        if reason:
            self._refused[signal] = reason
        else:
            self._refused.pop(signal, None)
        self._settle()

    def on_written(self, name: str, value: Value) -> None:
        """The controller has confirmed a value: what it makes from now on is the confirmed product."""
        if name == Signal.PRODUCT and value != self._kept.confirmed:
            self._kept = replace(self._kept, confirmed=str(value), confirmed_at=self._product_at)
            self._keep()

    @property
    def _product_at(self) -> str:
        """What is told the product; empty for nothing."""
        return self._mapping.source(Signal.PRODUCT) if Signal.PRODUCT in self._tags else ""

    # --- values ---

    def _take(self, signal: Signal, value: Value) -> str | None:
        """Process a value; returns why that is impossible, None otherwise."""
        tag = self._tags[signal]
        match signal:
            case Signal.PIECES | Signal.BAD:
                return self._take_count(signal, tag, value)
            case Signal.DOCK_READY:
                if not isinstance(value, bool | int):
                    return f"{quoted(value)} is neither true nor false"
                self._dock.ready(is_ready=bool(value) is not tag.invert)
            case Signal.FAULT:
                self._fault = brief(fault_words(value, inverted=tag.invert))
                self._resets = self._resets and bool(self._fault)
                self._put(Signal.RESET, self._resets)
            case Signal.FAULT_TEXT:
                self._fault_text = brief(str(value))
            case Signal.STATE:
                word = value.replace(" ", "").lower() if isinstance(value, str) else value
                if word not in STANDS and word not in WORKS:
                    return f"{quoted(value)} is no state that is known"
                self._standing = STANDS.get(word, "")
            case _:
                return "the controller is told this, and does not tell it"
        return None

    def _take_count(self, signal: Signal, tag: Tag, value: Value) -> str | None:
        """Count the value of a counter or a pulse."""
        moduli = self._moduli.get(signal, ())
        if tag.edge is not None:
            if not isinstance(value, bool):
                return f"{quoted(value)} is no pulse"
            number = int(value)
        elif isinstance(value, bool | str) or not math.isfinite(value):
            return f"{quoted(value)} is no count"
        else:
            number = round(value / tag.scale)
            if number < 0 and moduli:
                number %= max(moduli)  # A signed counter continues below 0.
            if number < 0:
                return f"{quoted(value)} is no count"
        is_bad, gap = signal is Signal.BAD, signal in self._gaps
        self._gaps.discard(signal)
        last = self._kept.bad if is_bad else self._kept.pieces
        now = CounterState(number, self._clock.now_s(), self._mapping.source(signal, moduli), self._broker)
        if last is None:
            reading = Reading()
        elif another := doubt_of_another(last, now, "made"):
            reading = Reading(0, another)
        elif tag.edge is not None:
            reading = count_pulse(bool(last.value), bool(number), tag.edge, gap=gap)
        else:
            reading = count(last, now, min(self._cycle_s.values()), moduli, gap=gap)
        doubt = f"{signal.value} {reading.doubt}" if reading.doubt else self._kept.doubt
        if reading.pieces and self._kept.unsure and not doubt:
            either = f"by {self._kept.held} or by {self._kept.cycling}"
            doubt = f"{signal.value} {UNSURE}, {either}"
        changes = {"bad": now} if is_bad else {"pieces": now}
        self._kept = replace(self._kept, doubt=doubt, **changes)
        was_reset = last is not None and tag.edge is None and number < last.value
        if reading.pieces or reading.doubt or last is None or was_reset:
            self._made(reading.pieces, bad=is_bad)
        return None

    def _made(self, pieces: int, *, bad: bool) -> None:
        """Count finished pieces."""
        reports = []
        for _ in range(min(pieces, COUNT_MAX)):
            wanted, self._turn = "" if self._kept.held else self._kept.cycling, self._turn + 1
            product = wanted or self._kept.held or self._kept.last
            if not wanted:
                self._use(product)
            if not bad:
                self._stock[product] = min(self._stock.get(product, 0) + 1, COUNT_MAX)
            cycling = self._kept.cycling if self._kept.held else ""
            self._kept = replace(self._kept, cycling=cycling, seq=self._kept.seq + 1)
            self._late = ""
            reports.append(CycleDone(product=product, seq=self._kept.seq, bad=bad))
        if pieces:
            self._put(Signal.RUN, False)
        self._keep()
        for report in reports:
            self._report(report)

    # --- instructions ---

    def _start(self, start: StartCycle) -> None:
        product = start.product
        if start.cycle_s > 0.0 and start.bill:
            self._cycle_s.setdefault(product, start.cycle_s)
        if start.bill:
            self._bills[product] = {line.material: line.quantity for line in start.bill}
        if reason := self._why_not(product):
            self._report(CycleFailed(product=product, reason=reason))
            return
        if self._kept.held:
            return
        waits = product != self._kept.last and self._clock.now_s() < self._held_until_s
        if not self._kept.cycling and not waits:
            self._use(product)
        self._kept = replace(self._kept, cycling=product, last=product, held=self._kept.last if waits else "")
        self._keep()
        if waits:
            self._wait()
        else:
            self._run(product)

    def _run(self, product: str) -> None:
        """Let the controller make a piece."""
        self._put(Signal.PRODUCT, product)
        self._put(Signal.RUN, True)
        self._expect(product)

    def _wait(self) -> None:
        """Let the held product begin when nothing of the last one can come any more."""
        if self._kept.held:
            self._clock.call_at(self._held_until_s, self._release)

    def _release(self) -> None:
        if not self._kept.held or self._away or self._clock.now_s() < self._held_until_s:
            return
        product, missing = self._kept.cycling, self._missing(self._kept.cycling)
        self._kept = replace(self._kept, held="", unsure=False, cycling="" if missing else product)
        if missing:
            # What came of the last product has used it.
            self._keep()
            self._report(CycleFailed(product=product, reason=missing))
            return
        self._use(product)
        self._keep()
        self._run(product)

    def _hold_unconfirmed(self) -> bool:
        """Let a product wait of which the controller may not have heard, since it may still make the last one; returns whether that is new."""
        kept = self._kept
        if kept.held or not kept.cycling or kept.confirmed in ("", kept.cycling):
            return False
        for item, pieces in self._bills.get(kept.cycling, {}).items():
            self._stock[item] = min(self._stock.get(item, 0) + pieces, COUNT_MAX)
        self._late, self._turn = "", self._turn + 1
        self._kept = replace(kept, held=kept.confirmed, unsure=True)
        self._keep()
        return True

    def _why_not(self, product: str) -> str:
        """The reason why a piece cannot be begun; empty for none."""
        if product not in self._cycle_s:
            return "not made here"
        if self._told[0]:
            return self._told[0]
        if self._kept.cycling not in ("", product):
            return f"busy with {self._kept.cycling}"
        if self._kept.cycling:
            return ""
        return self._missing(product)

    def _missing(self, product: str) -> str:
        """The material that is missing for a piece, in words; empty for none."""
        bill = self._bills.get(product, {})
        missing = [item for item, pieces in bill.items() if self._stock.get(item, 0) < pieces]
        return f"missing {', '.join(missing)}" if missing else ""

    def _use(self, product: str) -> None:
        """Use up the material of one piece."""
        for item, pieces in self._bills.get(product, {}).items():
            self._stock[item] = max(0, self._stock.get(item, 0) - pieces)

    def _move(self, book: Book) -> None:
        """Book a vehicle's report of a transfer; a repeated one is in the stock already."""
        item, change = book.item, book.change
        if name_of(book) not in self._kept.booked:
            if item != THING:
                self._stock[item] = min(max(self._stock.get(item, 0) + change, 0), COUNT_MAX)
            seq = self._kept.seq + 1
            booked = with_word(self._kept.booked, book, seq)
            self._kept = replace(self._kept, seq=seq, booked=booked)
            self._keep()
        seq = self._kept.booked[name_of(book)]
        self._report(StockChanged(item=item, change=change, seq=seq, vehicle=book.vehicle))

    def _reset(self) -> None:
        """A person has checked the problem."""
        if self._kept.doubt:
            self._kept = replace(self._kept, doubt="")
            self._keep()
        if self._late:
            self._expect(self._kept.cycling)
        if self._fault:
            self._resets = True
            self._put(Signal.RESET, True)

    def _expect(self, product: str) -> None:
        """Wait for a piece from now on."""
        self._late, self._turn = "", self._turn + 1
        patience_s = max(LATE_MIN_S, LATE_CYCLES * self._cycle_s.get(product, 0.0))
        since_s = self._clock.now_s()
        self._clock.call_at(since_s + patience_s, partial(self._miss, self._turn, patience_s))

    def _miss(self, turn: int, patience_s: float) -> None:
        if turn != self._turn or not self._kept.cycling:
            return
        if self._told[0]:
            self._expect(self._kept.cycling)  # It was impossible in that time: wait anew.
            return
        self._late = f"no piece of {self._kept.cycling} was counted for {patience_s:.0f} s"
        self._settle()

    # --- what follows ---

    def _settle(self) -> None:
        """Send changes to the controller and the agent."""
        vehicle = self._dock.vehicle
        self._put(Signal.DOCK_PERMIT, bool(vehicle))
        self._put(Signal.DOCK_VEHICLE, vehicle)
        if self._dock.state is not DockState.OPEN:
            self._told_ready = ""
        elif self._told_ready != vehicle:
            self._told_ready = vehicle
            if vehicle in self._loads:
                self._kept = replace(self._kept, let_in=self._loads.pop(vehicle))
                self._keep()
            self._report(DockReady(vehicle=vehicle))
        self._judge()

    def _judge(self) -> None:
        """Report the worst problem of the machine, when it has changed."""
        told = self._problem()
        if told == self._told:
            return
        was, self._told = self._told[0], told
        reason, problem, resettable = told
        if reason:
            self._report(Broken(reason=reason, problem=problem, resettable=resettable))
        elif was:
            self._report(Repaired())

    def _problem(self) -> tuple[str, Problem, bool]:
        if self._away:
            return f"its controller is not heard: {self._away}", _NO_LINK, False
        if self._fault or self._standing:
            what = self._fault_text or self._fault or self._standing
            return what, NOTHING_KNOWN, Signal.RESET in self._tags and bool(self._fault)
        for signal in (Signal.PIECES, Signal.BAD, Signal.FAULT, Signal.STATE):
            if signal in self._silent:
                return (
                    f"its controller has no value for {signal.value}: {self._silent[signal]}",
                    _NO_LINK,
                    False,
                )
        for signal, reason in self._refused.items():
            return f"its controller does not take {signal.value}: {reason}", _SOFTWARE, False
        if self._kept.doubt:
            return f"its count is in doubt: {self._kept.doubt}", _SOFTWARE, True
        return self._late, NOTHING_KNOWN, bool(self._late)

    def _put(self, signal: Signal, value: Value) -> None:
        tag = self._tags.get(signal)
        if tag is None:
            return
        if tag.invert and isinstance(value, bool):
            value = not value
        if self.outputs.get(signal) != value:
            self.outputs[signal] = value
            self._world.write()

    def _scale(self, signal: Signal) -> float:
        tag = self._tags.get(signal)
        return 1.0 if tag is None else tag.scale

    def _keep(self) -> None:
        opened, let_in = self._dock.waiting, self._kept.let_in
        if let_in is not None and let_in.vehicle not in opened:
            let_in = None
        self._kept = replace(self._kept, stock=dict(self._stock), opened=opened, let_in=let_in)
        self._world.remember(self._kept)
