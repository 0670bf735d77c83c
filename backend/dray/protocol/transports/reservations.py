"""What of a place's stock is promised to whom, and who waits for more. Pure.

    asked --enough is free--> RESERVED --fetched--> gone
      |                         |  ^
      +--> QUEUED --its turn----+  +-- asked again: it lapses later
            |                   |
            +-------------------+---- given back, or not asked for again in time: lapsed

The rules
---------
1. What is promised lies there: `promised <= level` of every material, at all times.
2. First come, first served, in one queue for each material; only a vehicle that stands at the dock goes before
   all others, for it blocks the place.
3. A reservation is for one task. When its epoch rises before anything was fetched it serves the next carrier; what was
   fetched is gone, and a higher epoch has to ask for other pieces.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

from dray.memory import ReservationMemory
from dray.messages import THING, StockAsked, StockLevel
from dray.messages.base import COUNT_MAX
from dray.protocol.runtime.bounded_map import BoundedMap
from dray.protocol.runtime.events import NEVER_S

LEASE_S = 180.0
"""A reservation lapses so long after it was asked for last: three times what passes between two renewals
(`sourcing.RENEW_S`), and longer than a machine needs to be started again."""

QUEUED_S = 30.0
"""A place in the queue lapses likewise: three times `sourcing.AGAIN_S`, or six questions of a vehicle at the dock."""

MAX_ASKED = 64
"""By one coordinator: more than its buffers hold lots. Whoever asks for more invents tasks."""

TAKEN_KEPT = 1024
"""Tasks whose load was fetched: a renewal that is under way for longer than so many has no sender any more."""


class Ask:
    """One task for which pieces are asked.

    Attributes:
        coordinator: who asks; empty while only a vehicle at the dock has spoken of it.
        vehicle: who fetches it: it stands at the dock; empty for nobody yet.
        opened: the epoch of the task in which the dock was opened for it; 0 before.
        reserved: the pieces are set aside.
        lapses_s: when it lapses.
    """

    __slots__ = (
        "coordinator",
        "epoch",
        "item",
        "lapses_s",
        "opened",
        "quantity",
        "reserved",
        "task",
        "vehicle",
    )

    def __init__(self, task: str, epoch: int, item: str, quantity: int, coordinator: str = "") -> None:
        self.task, self.epoch, self.item, self.quantity = task, epoch, item, quantity
        self.coordinator = coordinator
        self.vehicle = ""
        self.opened = 0
        self.reserved = False
        self.lapses_s = NEVER_S

    def memory(self) -> ReservationMemory:
        """For the next life."""
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
        capacity: pieces of every material that find room there.
    """

    def __init__(self, capacity: Mapping[str, int]) -> None:
        self._capacity = dict(capacity)
        self._level = dict.fromkeys(capacity, 0)
        self._seq = 0
        self._asks: dict[str, Ask] = {}
        """By task, in the order in which they were asked."""
        self._taken: BoundedMap[str, int] = BoundedMap(TAKEN_KEPT)
        """By task, the epoch in which its load was fetched."""

    def __iter__(self) -> Iterator[Ask]:
        return iter(self._asks.values())

    # --- what lies there ---

    def take_count(self, stock: Mapping[str, int], seq: int) -> None:
        """Take the storage's count at the start."""
        self._seq = seq
        self._set(stock)

    def assume(self, level: Callable[[str], int]) -> None:
        """Take the levels as somebody else keeps them, who hears of every change."""
        self._level = {item: level(item) for item in self._capacity}

    def sense(self, stock: Mapping[str, int], seq: int) -> bool:
        """Take its count, unless it is of another moment: what it has reported since is still to come.

        Returns:
            True when it is not what was believed.
        """
        if seq != self._seq:
            return False
        believed = self._level
        self._set(stock)
        return self._level != believed

    def change(self, item: str, pieces: int, seq: int) -> None:
        """Pieces came, or went if negative, as the storage reports; what is known already changes nothing.

        A level is never below 0, nor above what can be told: a storage that counts wrongly is heard all the same.
        """
        if seq <= self._seq:
            return
        self._seq = seq
        if item in self._level:
            self._level[item] = min(max(self._level[item] + pieces, 0), COUNT_MAX)

    def level(self, item: str) -> int:
        return self._level.get(item, 0)

    def room(self, item: str) -> int:
        """Pieces that still find room; of things that nobody counts as many as come."""
        if item == THING:
            return COUNT_MAX
        return self._capacity.get(item, 0) - self.level(item)

    def keep(self, item: str, capacity: int) -> None:
        """Something more may lie there; what does already is not changed."""
        if item not in self._capacity:
            self._capacity[item], self._level[item] = capacity, 0

    def free(self, item: str) -> int:
        """Pieces that are promised to nobody; of things that nobody counts whoever asks for one knows that it is there."""
        if item == THING:
            return COUNT_MAX
        return self.level(item) - self.promised(item)

    def promised(self, item: str) -> int:
        """Pieces that are set aside."""
        return self._sum(item, reserved=True)

    def asked(self, item: str) -> int:
        """Pieces that somebody waits for, or that are set aside."""
        return self._sum(item, reserved=False) + self.promised(item)

    def levels(self) -> tuple[StockLevel, ...]:
        """Everything, for the heartbeat."""
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
        """Whether so much can lie there at all."""
        if item == THING:
            return quantity == 1
        return 0 < quantity <= self._capacity.get(item, 0)

    # --- who asks ---

    def get(self, task: str) -> Ask | None:
        return self._asks.get(task)

    def was_taken(self, task: str, epoch: int) -> bool:
        """Whether the load was fetched in this epoch, or a later one."""
        return epoch <= self._taken.get(task, -1)

    def has_too_many(self, coordinator: str) -> bool:
        """Whether somebody asks for more than anybody needs."""
        return sum(ask.coordinator == coordinator for ask in self) >= MAX_ASKED

    def ask(self, asked: StockAsked, coordinator: str, now_s: float) -> Ask:
        """Note who asks, for the first time or again."""
        ask = self._asks.get(asked.task)
        if ask is None:
            ask = self._asks[asked.task] = Ask(
                asked.task, asked.epoch, asked.item, asked.quantity, coordinator
            )
        ask.coordinator, ask.epoch = coordinator, max(ask.epoch, asked.epoch)
        self.renew(ask, now_s)
        return ask

    def stand(self, vehicle: str, asked: StockAsked, now_s: float) -> Ask:
        """A vehicle asks at the dock for pieces that nobody has had set aside, or that could not be."""
        for other in [each for each in self if each.vehicle == vehicle and each.task != asked.task]:
            self.release(other)
        ask = self._asks.get(asked.task)
        if ask is None:
            ask = self._asks[asked.task] = Ask(asked.task, asked.epoch, asked.item, asked.quantity)
        ask.vehicle, ask.epoch = vehicle, max(ask.epoch, asked.epoch)
        self.renew(ask, now_s)
        return ask

    def renew(self, ask: Ask, now_s: float) -> None:
        """It was asked for again."""
        ask.lapses_s = now_s + (LEASE_S if ask.reserved else QUEUED_S)

    def release(self, ask: Ask) -> None:
        """Give a reservation, or its place in the queue, back."""
        self._asks.pop(ask.task, None)

    def take(self, vehicle: str, item: str) -> bool:
        """A vehicle has fetched what the dock was open for; False when that was nobody's."""
        for ask in self:
            if ask.opened and ask.vehicle == vehicle and ask.item == item:
                self._taken[ask.task] = ask.epoch
                self.release(ask)
                return True
        return False

    def promise(self, now_s: float) -> list[Ask]:
        """Reserve what is free, first come first served. Returns those that were reserved now."""
        promised: list[Ask] = []
        short: set[str] = set()  # Only ever asked for membership.
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
        """Cancel reservations that the stock does not cover, the latest first. Returns those that were cancelled."""
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
        """Materials for which somebody waits."""
        waiting = {ask.item for ask in self if not ask.reserved}
        return tuple(item for item in self._capacity if item in waiting)

    # --- over a restart ---

    def memories(self) -> tuple[ReservationMemory, ...]:
        """What is set aside; who waits asks again."""
        return tuple(ask.memory() for ask in self if ask.reserved)

    def restore(self, memory: ReservationMemory, opened: tuple[str, ...], now_s: float) -> None:
        """Go on with a reservation of an earlier life, unless its vehicle has fetched the load meanwhile."""
        if memory.vehicle and memory.vehicle not in opened:
            self._taken[memory.task] = memory.epoch
            return
        ask = self._asks[memory.task] = Ask(
            memory.task, memory.epoch, memory.item, memory.quantity, memory.coordinator
        )
        ask.vehicle, ask.opened, ask.reserved = memory.vehicle, memory.opened, True
        self.renew(ask, now_s)

    def _set(self, stock: Mapping[str, int]) -> None:
        self._level = {item: stock.get(item, 0) for item in self._capacity}

    def _sum(self, item: str, *, reserved: bool) -> int:
        return sum(ask.quantity for ask in self if ask.item == item and ask.reserved is reserved)
