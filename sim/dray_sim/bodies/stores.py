"""The sources and destinations of goods: storages and warehouses, and the interface of every place.

`Place` is a vehicle's view of a station: it takes something out or puts something in, at once, and wholly or not at
all. Every place counts, so that material can be balanced over a whole run (invariant 2):

    stock at the beginning + supplied = in storages + on board + in buffers + consumed + scrapped

Products without a permit at the delivery warehouse are set aside there, and counted too.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Container, Iterable, Mapping
from typing import Protocol

from dray.body import CloseDock, FillTo, Instruction, OpenDock, Refill, Report, StockChanged, StorageState
from dray.messages import THING
from dray.plant.model import Storage as StorageSpec
from dray.ports import Clock
from dray_sim.bodies.docks import OpenDocks
from dray_sim.bodies.gate import Gate
from dray_sim.bodies.reporter import Reporter

REFILL_S = 120.0
"""Time from the order of a refill to a full stock. The paper does not model this transport (4.1: material "is
supposed to be automatically distributed" to the storages). Two minutes fit a tugger train that is about."""

REFILL_BELOW_FRAC = 0.5
"""A stock below this part of its capacity is refilled."""

NO_ROOM = "no room"
TOO_LITTLE = "too little there"
NOT_KEPT = "not kept here"


class Place(Protocol):
    """A station as a vehicle meets it.

    Atomic: a transfer happens wholly at this instant, or not at all.
    """

    def take(self, vehicle: str, item: str, quantity: int) -> str:
        """Give pieces to a vehicle. Returns "" when it has them, else why not."""
        ...

    def put(self, vehicle: str, item: str, quantity: int, goal: str = "") -> str:
        """Receive pieces from a vehicle. Returns "" when they are in, else why not.

        `goal` is whose pieces these are; it matters only where goods leave the factory.
        """
        ...


class SourceWarehouse:
    """Unlimited material, counted as it leaves.

    Args:
        id_: the warehouse.
        materials: ids of its materials.

    Attributes:
        left: pieces that went out, by vehicle or as a refill.
        returned: pieces that vehicles brought back.
    """

    def __init__(self, id_: str, materials: Iterable[str]) -> None:
        self.id = id_
        self.left: Counter[str] = Counter()
        self.returned: Counter[str] = Counter()
        self._materials = frozenset(materials)

    def supplied(self, material: str) -> int:
        """Pieces that have come into the factory from here, on balance."""
        return self.left[material] - self.returned[material]

    def ship(self, material: str, quantity: int) -> None:
        """Send pieces to a storage; counted as they arrive there, so that none is ever in between."""
        self.left[material] += quantity

    def take(self, vehicle: str, item: str, quantity: int) -> str:
        """See `Place`."""
        if item not in self._materials:
            return NOT_KEPT
        self.left[item] += quantity
        return ""

    def put(self, vehicle: str, item: str, quantity: int, goal: str = "") -> str:
        """See `Place`. A superseded vehicle may bring its load back."""
        if item not in self._materials:
            return NOT_KEPT
        self.returned[item] += quantity
        return ""


class DeliveryWarehouse:
    """The destination of finished products, which counts them as they arrive.

    Args:
        id_: the warehouse.
        materials: ids that it does not accept.
        gate: admits goods by their goal; without one, all goods are let in.

    Attributes:
        arrived: pieces of every product that went out to customers.
        aside: pieces of every product that were put down here without being admitted.
    """

    def __init__(self, id_: str, materials: Iterable[str], gate: Gate | None = None) -> None:
        self.id = id_
        self.arrived: Counter[str] = Counter()
        self.aside: Counter[str] = Counter()
        self._materials = frozenset(materials)
        self._gate = gate

    def take(self, vehicle: str, item: str, quantity: int) -> str:
        """See `Place`. Delivered goods stay delivered."""
        return NOT_KEPT

    def put(self, vehicle: str, item: str, quantity: int, goal: str = "") -> str:
        """See `Place`. With a gate, goods of a goal need its permit; goods without a goal are set aside."""
        if item in self._materials:
            return NOT_KEPT
        if self._gate is not None:
            if not goal:
                self.aside[item] += quantity
                return ""
            reason = self._gate.enter(goal, quantity, vehicle)
            if reason:
                return reason
        self.arrived[item] += quantity
        return ""


class Storage:
    """A storage: the body of its station.

    One that fills itself is refilled from the source warehouse; a source warehouse is refilled from outside.

    Implements `dray.ports.Body` and `Place`. A vehicle fetches only the load for which the dock is open; people help
    themselves. Returned pieces are accepted without a dock.

    Invariants: a stock is never negative and never above its capacity; each material has at most one refill on its
    way.

    Args:
        spec: which materials, and how many pieces of each.
        clock: the plant's clock.
        source: where refills come from.
        refill_s: from the order of a refill to its arrival.
        stock: pieces at the beginning; full where a material is not named, and of parts none.
        parts: items that machines of this factory make: they are never refilled.
        takes_all: returned pieces always find room, as in a source warehouse, the last destination of material
            without another place.

    Attributes:
        stock: pieces of every material.
        things: things without master data that were brought here, less those that were fetched; the number at the
            beginning is unknown.
        filled: pieces that lay there after the last refill, by material.
        refills: number of refills, by material.
    """

    def __init__(
        self,
        spec: StorageSpec,
        clock: Clock,
        source: SourceWarehouse,
        refill_s: float = REFILL_S,
        stock: Mapping[str, int] | None = None,
        parts: Container[str] = (),
        takes_all: bool = False,
    ) -> None:
        self.id = spec.id
        self._clock = clock
        self._parts = parts
        self._source = source
        self._refill_s = refill_s
        self._capacity = {kept.material: kept.capacity for kept in spec.stocks}
        begin = {item: 0 for item in self._capacity if item in parts} | dict(stock or {})
        self.stock = {item: min(begin.get(item, room), room) for item, room in self._capacity.items()}
        self.things = 0
        self.filled: dict[str, int] = {}
        self.refills: Counter[str] = Counter()
        self._fill_to = dict(self._capacity)
        self._seq = 0
        """Number of the last change of the stock that a report tells of."""
        self._takes_all = takes_all
        self._docks = OpenDocks()
        self._reporter = Reporter(clock)
        self._ordered: set[str] = set()
        self._fills_itself = spec.refill == "itself"
        for item in self.stock:
            self._order_if_low(item)

    # --- Body ------------------------------------------------------------------------------------

    def instruct(self, instruction: Instruction) -> None:
        """See `dray.ports.Body`. Other instructions are ignored: no report would fit them."""
        if isinstance(instruction, OpenDock):
            self._docks.open(instruction.vehicle, instruction.item, instruction.quantity)
        elif isinstance(instruction, CloseDock):
            self._docks.shut(instruction.vehicle)
        elif isinstance(instruction, Refill) and instruction.item in self.stock:
            self._order(instruction.item)
        elif isinstance(instruction, FillTo) and instruction.item in self.stock:
            self._fill_to[instruction.item] = min(instruction.quantity, self._capacity[instruction.item])
            self._order_if_low(instruction.item)

    def sense(self) -> StorageState:
        """See `dray.ports.Body`."""
        return StorageState(stock=dict(self.stock), seq=self._seq, opened=tuple(self._docks))

    def attach(self, report: Callable[[Report], None]) -> None:
        """See `dray.ports.Body`."""
        self._reporter.attach(report)

    # --- Place -----------------------------------------------------------------------------------

    def take(self, vehicle: str, item: str, quantity: int) -> str:
        """See `Place`. A vehicle takes only the load for which the dock is open; without a vehicle it is a person."""
        at_hand = 1 if item == THING else self.stock.get(item)
        if at_hand is None:
            return NOT_KEPT
        if vehicle and (reason := self._docks.refusal(vehicle, item, quantity)):
            return reason
        if quantity > at_hand:
            return TOO_LITTLE
        self._docks.shut(vehicle)
        self._change(item, -quantity, vehicle)
        if item != THING:
            self._order_if_low(item)
        return ""

    def put(self, vehicle: str, item: str, quantity: int, goal: str = "") -> str:
        """See `Place`. A superseded vehicle may bring its load back."""
        if item == THING:
            self._change(item, quantity, vehicle)
            return ""
        at_hand = self.stock.get(item)
        if at_hand is None:
            return NOT_KEPT
        if at_hand + quantity > self._capacity[item] and not self._takes_all:
            return NO_ROOM
        self._change(item, quantity, vehicle)
        return ""

    # --- how it is done --------------------------------------------------------------------------

    def _order_if_low(self, item: str) -> None:
        if self.stock[item] < min(REFILL_BELOW_FRAC * self._capacity[item], self._fill_to[item]):
            self._order(item)

    def _order(self, item: str) -> None:
        if self._fills_itself and item not in self._ordered and item not in self._parts:
            self._ordered.add(item)
            self._clock.call_at(self._clock.now_s() + self._refill_s, lambda: self._refill(item))

    def _refill(self, item: str) -> None:
        """Fill up what is missing now: vehicles may have brought some meanwhile, or may be bringing some."""
        self._ordered.discard(item)
        missing = max(0, self._fill_to[item] - self.stock[item])
        self._source.ship(item, missing)
        self._change(item, missing)
        if missing:
            self.filled[item] = self.stock[item]
            self.refills[item] += 1

    def _change(self, item: str, pieces: int, vehicle: str = "") -> None:
        if item == THING:
            self.things += pieces
        else:
            self.stock[item] += pieces
        self._seq += 1
        self._reporter.say(StockChanged(item=item, change=pieces, seq=self._seq, vehicle=vehicle))
        self._reporter.flush_soon()
