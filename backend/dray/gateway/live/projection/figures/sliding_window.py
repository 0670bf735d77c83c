"""Sums over a sliding window of time, at a cost independent of the number of values."""

from __future__ import annotations


class Window:
    """The last `slots` slots of `slot_s` seconds each.

    Args:
        slot_s: length of a slot, in seconds of the caller's clock.
        slots: number of slots.
    """

    __slots__ = ("_begins_s", "_ends_s", "_head", "_sums", "slot_s", "slots")

    def __init__(self, slot_s: float, slots: int) -> None:
        self.slot_s, self.slots = slot_s, slots
        self._sums = [0.0] * slots
        self._head = 0
        """Number of the newest slot since the clock's zero."""
        self._begins_s, self._ends_s = 0.0, slot_s
        """Bounds of the newest slot, which takes nearly all values."""

    def add(self, at_s: float, amount: float) -> None:
        """Add to the slot of `at_s`; values older than the window are ignored."""
        if self._begins_s <= at_s < self._ends_s:
            self._sums[self._head % self.slots] += amount
            return
        number = int(at_s // self.slot_s)
        if number > self._head:
            self._turn(number)
        if number > self._head - self.slots:
            self._sums[number % self.slots] += amount

    def sums(self, now_s: float, groups: int) -> tuple[float, ...]:
        """The window that ends now, in `groups` parts of equal length, oldest first.

        Args:
            now_s: the end of the window.
            groups: a divisor of `slots`.
        """
        self._turn(int(now_s // self.slot_s))
        size = self.slots // groups
        first = self._head + 1
        in_order = [self._sums[number % self.slots] for number in range(first, first + self.slots)]
        return tuple(sum(in_order[start : start + size]) for start in range(0, self.slots, size))

    def _turn(self, number: int) -> None:
        """Make `number` the newest slot, and empty the slots passed."""
        if number <= self._head:
            return
        for passed in range(max(self._head + 1, number - self.slots + 1), number + 1):
            self._sums[passed % self.slots] = 0.0
        self._head = number
        self._begins_s, self._ends_s = number * self.slot_s, (number + 1) * self.slot_s
