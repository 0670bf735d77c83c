"""Reservations of a place's stock, and the queue for more. Pure.

    asked --enough is free--> RESERVED --fetched--> gone
      |                         |  ^
      +--> QUEUED --its turn----+  +-- asked again: it lapses later
            |                   |
            +-------------------+---- given back, or not asked for again in time: lapsed

The rules
---------
1. Promised pieces lie there: `promised <= level` of every material, at all times.
2. First come, first served, in one queue per material. Only a vehicle at the dock has precedence, because it blocks
   the place.
3. A reservation is for one task. If its epoch rises before the load was fetched, it serves the next carrier.
   Fetched pieces are gone, and a higher epoch has to ask for others.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

from dray.memory import DepartureMemory, ReservationMemory
from dray.messages import THING, StockAsked, StockLevel
from dray.messages.base import COUNT_MAX
from dray.protocol.runtime.bounded_map import BoundedMap
from dray.protocol.runtime.events import NEVER_S

LEASE_S = 180.0
"""Lease of a reservation since its last request (s): three renewal intervals (`sourcing.RENEW_S`), and longer than a
machine's restart."""

QUEUED_S = 30.0
"""Lease of a place in the queue (s): three times `sourcing.AGAIN_S`, or six requests of a vehicle at the dock."""

MAX_ASKED = 64
"""Maximum open requests per coordinator: more than its buffers hold lots. A coordinator with more invents tasks."""

AHEAD_MAX = 8
"""Maximum number of carriers that have replaced one another before the coordinator names the epoch again
(`sourcing.RENEW_S`)."""

REFUTED_S = 30.0
"""Time in which a coordinator hears of a carrier that has taken over (s). After it the dock is no longer kept for an epoch above the one
that the coordinator names."""

TAKEN_KEPT = 1024
"""Remembered tasks whose load was fetched: a renewal older than so many has no sender any more."""


class Ask:
    """The pieces requested for one task.

    Attributes:
        coordinator: the requesting coordinator; empty if only a vehicle at the dock has named the task.
        vehicle: the fetching vehicle, which stands at the dock; empty before.
        epoch: the task's, as its coordinator has said; as a vehicle at the dock has said if no coordinator has.
        opened: the task's epoch in which the dock was opened for it; 0 before.
        opened_s: when it was opened.
        refuted: whether the coordinator has named a lower epoch since then.
        reserved: whether the pieces are set aside.
        lapses_s: end of its lease.
    """

    __slots__ = (
        "coordinator",
        "epoch",
        "item",
        "lapses_s",
        "opened",
        "opened_s",
        "quantity",
        "refuted",
        "reserved",
        "task",
        "vehicle",
    )

    def __init__(self, task: str, epoch: int, item: str, quantity: int, coordinator: str = "") -> None:
        self.task, self.epoch, self.item, self.quantity = task, epoch, item, quantity
        self.coordinator = coordinator
        self.vehicle = ""
        self.opened = 0
        self.opened_s = -NEVER_S
        self.refuted = False
        self.reserved = False
        self.lapses_s = NEVER_S

    def is_of_its_carrier(self, vehicle: str, epoch: int) -> bool:
        """Whether this vehicle at the dock may fetch it, by the epoch that it states.

        No vehicle states an epoch far above the coordinator's, which alone raises it. One that has stated a slightly higher one was a
        liar, or was replaced, when the coordinator still names the lower one much later.
        """
        if self.coordinator and epoch > self.epoch + AHEAD_MAX:
            return False
        return vehicle == self.vehicle or epoch > self.opened or (self.refuted and epoch == self.epoch)

    def open(self, vehicle: str, epoch: int, now_s: float) -> None:
        """The dock is opened for this vehicle."""
        if (vehicle, epoch) != (self.vehicle, self.opened):
            self.opened_s, self.refuted = now_s, False
        self.vehicle, self.opened = vehicle, epoch

    def load(self) -> DepartureMemory:
        """What the vehicle may take for which the dock was opened."""
        pieces, coordinator = -self.quantity, self.coordinator
        return DepartureMemory(
            self.vehicle, self.task, self.opened, self.item, pieces, coordinator=coordinator
        )

    def memory(self) -> ReservationMemory:
        """The record for the next life."""
        return ReservationMemory(
            task=self.task,
            epoch=self.epoch,
            item=self.item,
            quantity=self.quantity,
            coordinator=self.coordinator,
            vehicle=self.vehicle if self.opened else "",
            opened=self.opened,
        )


class Reservations:
    """The reservations of one place.

    Args:
        capacity: pieces of every material for which there is room.
    """

    def __init__(self, capacity: Mapping[str, int]) -> None:
        self._capacity = dict(capacity)
        self._level = dict.fromkeys(capacity, 0)
        self._seq = 0
        self._asks: dict[str, Ask] = {}
        """By task, in the order of their requests."""
        self._taken: BoundedMap[str, int] = BoundedMap(TAKEN_KEPT)
        """By task: the epoch in which its load was fetched."""

    def __iter__(self) -> Iterator[Ask]:
        return iter(self._asks.values())

    # --- stock ---

    def take_count(self, stock: Mapping[str, int], seq: int) -> None:
        """Take the storage's initial count."""
        self._seq = seq
        self._set(stock)

    def assume(self, level: Callable[[str], int]) -> None:
        """Take the levels from another bookkeeper that hears of every change."""
        self._level = {item: level(item) for item in self._capacity}

    def sense(self, stock: Mapping[str, int], seq: int) -> bool:
        """Take the storage's count, unless reports on later changes are still to come.

        Returns:
            True if it differs from the levels here.
        """
        if seq != self._seq:
            return False
        believed = self._level
        self._set(stock)
        return self._level != believed

    def change(self, item: str, pieces: int, seq: int) -> None:
        """Apply a reported change of pieces, negative for taken ones; an old report is ignored.

        A level is kept between 0 and COUNT_MAX, so that a wrong count of a storage has no other effect.
        """
        if seq <= self._seq:
            return
        self._seq = seq
        if item in self._level:
            self._level[item] = min(max(self._level[item] + pieces, 0), COUNT_MAX)

    def level(self, item: str) -> int:
        return self._level.get(item, 0)

    def room(self, item: str) -> int:
        """Pieces for which there is room; unlimited for things, which are not counted."""
        if item == THING:
            return COUNT_MAX
        return self._capacity.get(item, 0) - self.level(item)

    def lacks_goods(self, _item: str, _quantity: int) -> bool:
        """False: a storage makes nothing."""
        return False

    def keep(self, item: str, capacity: int) -> None:
        """Add an item that may lie there; a known item is not changed."""
        if item not in self._capacity:
            self._capacity[item], self._level[item] = capacity, 0

    def free(self, item: str) -> int:
        """Pieces without a reservation; unlimited for things: their requester knows that they are there."""
        if item == THING:
            return COUNT_MAX
        return self.level(item) - self.promised(item)

    def promised(self, item: str) -> int:
        """Pieces that are set aside."""
        return self._sum(item, reserved=True)

    def asked(self, item: str) -> int:
        """Pieces that are requested or set aside."""
        return self._sum(item, reserved=False) + self.promised(item)

    def levels(self) -> tuple[StockLevel, ...]:
        """All levels, for the heartbeat."""
        return tuple(
            StockLevel(
                item=item,
                level=self._level[item],
                capacity=capacity,
                promised=self._sum(item, reserved=True),
                wanted=self._sum(item, reserved=False),
            )
            for item, capacity in self._capacity.items()
        )

    def holds(self, item: str, quantity: int) -> bool:
        """Whether this quantity can lie there at all."""
        if item == THING:
            return quantity == 1
        return 0 < quantity <= self._capacity.get(item, 0)

    # --- requests ---

    def get(self, task: str) -> Ask | None:
        return self._asks.get(task)

    def was_taken(self, task: str, epoch: int) -> bool:
        """Whether the load was fetched in this epoch, or a later one."""
        return epoch <= self._taken.get(task, -1)

    def has_too_many(self, coordinator: str) -> bool:
        """Whether a coordinator has MAX_ASKED open requests."""
        return sum(ask.coordinator == coordinator for ask in self) >= MAX_ASKED

    def ask(self, asked: StockAsked, coordinator: str, now_s: float) -> Ask:
        """Note a request, new or repeated."""
        ask = self._asks.get(asked.task)
        if ask is None:
            ask = self._asks[asked.task] = Ask(
                asked.task, asked.epoch, asked.item, asked.quantity, coordinator
            )
        ask.epoch = max(ask.epoch, asked.epoch) if ask.coordinator else asked.epoch
        ask.coordinator = coordinator
        ask.refuted |= asked.epoch < ask.opened and now_s - ask.opened_s > REFUTED_S
        self.renew(ask, now_s)
        return ask

    def stand(self, vehicle: str, asked: StockAsked, now_s: float) -> Ask:
        """A vehicle at the dock asks for pieces that are not set aside."""
        for other in [each for each in self if each.vehicle == vehicle and each.task != asked.task]:
            self.release(other)
        ask = self._asks.get(asked.task)
        if ask is None:
            ask = self._asks[asked.task] = Ask(asked.task, asked.epoch, asked.item, asked.quantity)
        ask.vehicle = vehicle
        if not ask.coordinator:
            ask.epoch = max(ask.epoch, asked.epoch)
        self.renew(ask, now_s)
        return ask

    def renew(self, ask: Ask, now_s: float) -> None:
        """Extend the lease after a repeated request."""
        ask.lapses_s = now_s + (LEASE_S if ask.reserved else QUEUED_S)

    def release(self, ask: Ask) -> None:
        """Give back a reservation, or its place in the queue."""
        self._asks.pop(ask.task, None)

    def take(self, vehicle: str, item: str) -> bool:
        """A vehicle has fetched the load that the dock was open for; False if there was none."""
        for ask in self:
            if ask.opened and ask.vehicle == vehicle and ask.item == item:
                self._taken[ask.task] = _fetched_in(ask.epoch, ask.opened)
                self.release(ask)
                return True
        return False

    def promise(self, now_s: float) -> list[Ask]:
        """Reserve free pieces, first come, first served. Returns the new reservations."""
        promised: list[Ask] = []
        short: set[str] = set()  # Membership tests only.
        for ask in sorted((each for each in self if not each.reserved), key=lambda each: not each.vehicle):
            if ask.item in short:
                continue
            if self.free(ask.item) < ask.quantity:
                short.add(ask.item)
                continue
            ask.reserved = True
            self.renew(ask, now_s)
            promised.append(ask)
        return promised

    def overdrawn(self) -> list[Ask]:
        """Cancel reservations that the stock does not cover, the latest first. Returns them."""
        broken: list[Ask] = []
        latest_first = tuple(reversed(self._asks.values()))
        for ask in sorted(latest_first, key=lambda each: bool(each.vehicle)):
            if ask.reserved and self.free(ask.item) < 0:
                ask.reserved, ask.opened = False, 0
                broken.append(ask)
        return broken

    def lapsed(self, now_s: float) -> list[Ask]:
        """Drop reservations that were not renewed in time. Returns them."""
        late = [ask for ask in self if ask.lapses_s <= now_s]
        for ask in late:
            self.release(ask)
        return late

    @property
    def next_lapse_s(self) -> float:
        return min((ask.lapses_s for ask in self), default=NEVER_S)

    @property
    def short_items(self) -> tuple[str, ...]:
        """Materials with a queue."""
        waiting = {ask.item for ask in self if not ask.reserved}
        return tuple(item for item in self._capacity if item in waiting)

    # --- over a restart ---

    def memories(self) -> tuple[ReservationMemory, ...]:
        """The reservations; queued requests are repeated by their coordinators."""
        return tuple(ask.memory() for ask in self if ask.reserved)

    def restore(self, memory: ReservationMemory, opened: tuple[str, ...], now_s: float) -> None:
        """Restore a reservation of an earlier life, unless its vehicle has fetched the load meanwhile."""
        if memory.vehicle and memory.vehicle not in opened:
            self._taken[memory.task] = _fetched_in(memory.epoch, memory.opened)
            return
        ask = self._asks[memory.task] = Ask(
            memory.task, memory.epoch, memory.item, memory.quantity, memory.coordinator
        )
        ask.vehicle, ask.opened, ask.opened_s, ask.reserved = memory.vehicle, memory.opened, now_s, True
        self.renew(ask, now_s)

    def _set(self, stock: Mapping[str, int]) -> None:
        self._level = {item: stock.get(item, 0) for item in self._capacity}

    def _sum(self, item: str, *, reserved: bool) -> int:
        return sum(ask.quantity for ask in self if ask.item == item and ask.reserved is reserved)


def _fetched_in(epoch: int, opened: int) -> int:
    """The epoch whose load was fetched: that of the carrier for which the dock was open, and no far later one than its coordinator's."""
    return min(opened, epoch + AHEAD_MAX)
