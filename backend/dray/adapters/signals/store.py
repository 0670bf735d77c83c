"""The body of a storage or warehouse station with single-value signals at its dock.

The stock is calculated from vehicles' reports of their transfers. Where the controller measures a material's level, the level prevails: a
difference at rest, with no vehicle at the dock, was moved by somebody else.

A level is at rest when all its values within a time of the plant's clock (`RESTS_S`) lie in a band of `BAND_PIECES`. A sensor may jitter there
for ever. The stock stays as it is while it lies between the lowest and the highest of these values; otherwise it becomes their middle.

A level may also be a switch (`Tag.at_least`). It is at rest when it has not changed for that time. It bounds the stock and counts nothing: a
stock beyond its bound becomes the bound.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Protocol

from msgspec import Struct
from msgspec.structs import replace

from dray.adapters.signals.dock import DockHandshake, DockState
from dray.adapters.signals.signal import LEVEL, Quality, Sample, Signal, SignalMapping, Value, bounds
from dray.adapters.vehicles_words import name_of, with_word
from dray.body import Book, CloseDock, DockReady, Instruction, OpenDock, Report, StockChanged, StorageState
from dray.messages import THING
from dray.messages.base import COUNT_MAX
from dray.plant.model import Storage as StorageSpec
from dray.ports import Clock, nobody_hears

RESTS_S = 10.0
"""The time of rest after which a level counts: a sensor is slower than a vehicle's report, and people fill piece by piece."""

REST_WALL_S = 1.0
"""At least this long in real seconds, where the plant's clock runs faster: a level takes a fifth of one to arrive."""

BAND_PIECES = 2
"""The band of a level at rest, from lowest to highest: a scale may alternate between two numbers, or shake by one piece either way."""


class KeptStore(Struct, frozen=True):
    """A storage's memory for the agent's next life."""

    stock: dict[str, int]
    seq: int = 0
    opened: tuple[str, ...] = ()
    booked: dict[str, int] = {}
    """The vehicles' latest reports, each with the number of its stock change."""
    uncounted: tuple[str, ...] = ()
    """Materials with an unknown count; `stock` contains only their later changes."""
    damaged: bool = False
    """Whether the earlier memory is lost."""


DAMAGED_STORE = KeptStore({}, damaged=True)
"""The memory after unreadable data."""


class Range(Struct, frozen=True):
    """The range of a level since its observation began, or the bounds by its switch."""

    low: int
    high: int
    turn: int
    """The number of the clock call that ends the observation, so that an outdated call is recognised."""


class World(Protocol):
    """The surroundings of the body, beside its clock."""

    def remember(self, kept: KeptStore) -> None:
        """Store the memory: on the disk at the return."""

    def write(self) -> None:
        """The body's `outputs` have changed: send them to the controller."""


class SignalledStore:
    """Implements `dray.ports.Body` and the listener of a link.

    Args:
        spec: the storage.
        mapping: its controller's signals.
        clock: the plant's.
        world: the disk and the link.
        kept: the last life's memory; None for the first one.
        rests_s: the time of rest after which a level counts.

    Attributes:
        outputs: the wanted outputs, by signal; a link writes the differences.
        away_since_s: the time of the loss of the controller; None while it is connected.
        away: the reason for the loss; empty while it is connected.
    """

    def __init__(
        self,
        spec: StorageSpec,
        mapping: SignalMapping,
        clock: Clock,
        world: World,
        kept: KeptStore | None = None,
        *,
        rests_s: float = RESTS_S,
    ) -> None:
        self._rests_s = rests_s
        self._tags, self._levels, self._clock, self._world = mapping.signals, mapping.levels, clock, world
        self._kept = kept or KeptStore(mapping.stock)
        self._stock = {line.material: 0 for line in spec.stocks} | self._kept.stock
        if self._kept.damaged:
            self._kept = replace(self._kept, damaged=False, uncounted=tuple(self._stock))
        self._told: dict[str, tuple[int, int]] = {}
        """The fewest and the most pieces by material, by the controller's last value; absent without a good one."""
        self._turn = 0
        self._ranges: dict[str, Range] = {}
        """The observed range of a level by material; absent for levels that rest at one value."""
        self._dock = DockHandshake(answers=Signal.DOCK_READY in self._tags)
        self._told_ready = ""
        self._report: Callable[[Report], None] = nobody_hears
        self.outputs: dict[str, Value] = {}
        self.away_since_s: float | None = clock.now_s()
        self.away = "nothing was heard of its controller yet"
        for vehicle in self._kept.opened:
            self._dock.want(vehicle)
        self._settle()

    # --- Body ---

    def instruct(self, instruction: Instruction) -> None:
        """See `dray.ports.Body`. Other instructions are ignored: people refill, or the agent orders it."""
        match instruction:
            case OpenDock(vehicle=vehicle):
                self._told_ready = "" if self._told_ready == vehicle else self._told_ready
                self._dock.want(vehicle)
            case CloseDock(vehicle=vehicle):
                self._dock.done(vehicle)
            case Book():
                self._dock.done(instruction.vehicle)
                self._book(instruction)
            case _:
                return
        if self._dock.waiting != self._kept.opened:
            self._keep()
        self._settle()

    def sense(self) -> StorageState:
        """See `dray.ports.Body`."""
        return StorageState(
            stock=dict(self._stock),
            seq=self._kept.seq,
            opened=self._dock.waiting,
            answers=True,
            counts=False,
            uncounted=self._kept.uncounted,
            measured=tuple(item for item, tag in self._levels.items() if tag.at_least is None),
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
        self.away_since_s, self.away = None, ""
        self._settle()

    def on_link_lost(self, reason: str) -> None:
        """The controller is away: nothing at the dock is safe, and its levels are outdated."""
        if self.away_since_s is None:
            self.away_since_s = self._clock.now_s()
        self.away = reason
        self._told.clear()
        self._ranges.clear()
        self._dock.lost()
        self._settle()

    def on_range(self, signal: str, moduli: tuple[int, ...]) -> None:
        """Ignore it: a level does not roll over."""

    def on_refused(self, name: str, reason: str) -> None:
        """Ignore it: a dock whose permit is refused does not get ready, which the station reports."""

    def on_written(self, name: str, value: Value) -> None:
        """Ignore it: `dock_ready` answers a permit."""

    def on_sample(self, name: str, sample: Sample) -> None:
        """The controller has sent a value."""
        is_good = sample.quality is Quality.GOOD
        if name == Signal.DOCK_READY:
            if is_good and isinstance(sample.value, bool | int):
                self._dock.ready(is_ready=bool(sample.value) is not self._tags[Signal.DOCK_READY].invert)
            else:
                self._dock.lost()
        elif name.startswith(LEVEL):
            item = name.removeprefix(LEVEL)
            self._on_level(item, bounds(sample.value, self._levels[item]) if is_good else None)
        self._settle()

    # --- what lies there ---

    def _book(self, book: Book) -> None:
        """Book a vehicle's report of a transfer; a repeated one is in the stock already."""
        if name_of(book) not in self._kept.booked:
            self._move(book.item, book.change)
            booked = with_word(self._kept.booked, book, self._kept.seq)
            self._kept = replace(self._kept, booked=booked)
            self._keep()
        seq = self._kept.booked[name_of(book)]
        self._report(StockChanged(item=book.item, change=book.change, seq=seq, vehicle=book.vehicle))
        self._watch_all()

    def _move(self, item: str, change: int) -> None:
        if item != THING:
            self._stock[item] = min(max(self._stock.get(item, 0) + change, 0), COUNT_MAX)
        self._kept = replace(self._kept, seq=self._kept.seq + 1)

    def _watch(self, item: str) -> None:
        """Observe a level from now on."""
        self._turn += 1
        low, high = self._told[item]
        self._ranges[item] = Range(low, high, self._turn)
        self._clock.call_at(self._clock.now_s() + self._rests_s, partial(self._compare, item, self._turn))

    def _watch_all(self) -> None:
        """After a transfer here, observe all levels anew."""
        for item in self._told:
            self._watch(item)

    def _on_level(self, item: str, level: tuple[int, int] | None) -> None:
        if level == self._told.get(item):
            return
        if level is None:
            del self._told[item]
            self._ranges.pop(item, None)
            return
        self._told[item] = level
        seen = self._ranges.get(item)
        if seen is not None:
            seen = replace(seen, low=min(seen.low, level[0]), high=max(seen.high, level[1]))
        if seen is None or self._is_switch(item) or seen.high - seen.low > BAND_PIECES:
            self._watch(item)
        else:
            self._ranges[item] = seen

    def _compare(self, item: str, turn: int) -> None:
        """Use a level that has been at rest since `_watch`."""
        seen = self._ranges.get(item)
        if seen is None or seen.turn != turn:
            return
        if self._dock.state is not DockState.SHUT:
            self._watch(item)  # A vehicle at the dock reports its own transfer.
            return
        self._take_level(item, seen)
        if (seen.low, seen.high) == self._told[item]:
            del self._ranges[item]
        else:
            self._watch(item)

    def _take_level(self, item: str, seen: Range) -> None:
        """Correct the stock by the level, within the sensor's precision. What nobody has counted stays so by a mere bound."""
        stock, counted = self._stock.get(item, 0), item in self._kept.uncounted
        if not self._is_switch(item):
            right = (seen.low + seen.high) // 2
        elif counted and seen.low != seen.high:
            return
        else:
            right = min(max(stock, seen.low), seen.high)
        change = 0 if seen.low <= stock <= seen.high else right - stock
        if not change and not counted:
            return
        self._move(item, change)
        left = tuple(each for each in self._kept.uncounted if each != item)
        self._kept = replace(self._kept, uncounted=left)
        self._keep()
        self._report(StockChanged(item=item, change=change, seq=self._kept.seq, counted=counted))

    def _is_switch(self, item: str) -> bool:
        return self._levels[item].at_least is not None

    # --- what follows ---

    def _settle(self) -> None:
        """Send changes to the controller and the agent."""
        vehicle = self._dock.vehicle
        permit: Value = bool(vehicle)
        if Signal.DOCK_PERMIT in self._tags and self._tags[Signal.DOCK_PERMIT].invert:
            permit = not permit
        for signal, value in ((Signal.DOCK_PERMIT, permit), (Signal.DOCK_VEHICLE, vehicle)):
            if signal in self._tags and self.outputs.get(signal) != value:
                self.outputs[signal] = value
                self._world.write()
        if self._dock.state is not DockState.OPEN:
            self._told_ready = ""
        elif self._told_ready != vehicle:
            self._told_ready = vehicle
            self._report(DockReady(vehicle=vehicle))

    def _keep(self) -> None:
        self._kept = replace(self._kept, stock=dict(self._stock), opened=self._dock.waiting)
        self._world.remember(self._kept)


def rests_s(speed: float) -> float:
    """The time of rest after which a level counts, at this speed of the plant's clock."""
    return max(RESTS_S, REST_WALL_S * speed)
