"""Pieces that people hold out at a node of the floor, for vehicles to take."""

from __future__ import annotations

from collections import Counter

NOBODY_THERE = "nobody hands it over"
NOBODY_TAKES = "nobody takes it here"


class HeldOut:
    """Pieces in people's hands that a vehicle may take at one node. Implements `dray_sim.bodies.stores.Place`.

    Args:
        in_hands: all pieces in people's hands, by item, of which these are a part.
    """

    def __init__(self, in_hands: Counter[str]) -> None:
        self._in_hands = in_hands
        self._there: Counter[str] = Counter()

    def offer(self, item: str, quantity: int) -> None:
        """Hold so many out, of those in one's hands."""
        self._there[item] += quantity

    def has(self, item: str, quantity: int) -> bool:
        """Whether so many are held out."""
        return self._there[item] >= quantity

    def take_back(self, item: str, quantity: int) -> None:
        """Hold so many out no more."""
        self._there[item] -= quantity

    def take(self, vehicle: str, item: str, quantity: int) -> str:
        """Give pieces to a vehicle, wholly or not at all. Returns "" when it has them, else why not."""
        if not self.has(item, quantity):
            return NOBODY_THERE
        self._there[item] -= quantity
        self._in_hands[item] -= quantity
        return ""

    def put(self, vehicle: str, item: str, quantity: int, goal: str = "") -> str:
        """Refuse: a vehicle puts nothing down on a lane."""
        return NOBODY_TAKES
