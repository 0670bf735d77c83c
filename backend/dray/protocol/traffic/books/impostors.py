"""Impostors: who speaks in the name of a vehicle that holds places, and has not its key. Its wishes change nothing; people are told."""

from __future__ import annotations

from dray.messages.fact import NameMisused
from dray.protocol.runtime.bounded_map import BoundedMap
from dray.protocol.runtime.events import Effect, Ignore, Record

ANOTHERS_KEY = "a wish that is not signed by the vehicle that holds places in this name"

TOLD_EVERY_S = 60.0
"""People look once a minute at most."""

NAMES_KEPT = 1024
"""More vehicles than any keeper hears; one that is forgotten is told of once more."""


class Impostors:
    """Of one agent's books.

    Args:
        out: where effects go.
    """

    def __init__(self, out: list[Effect]) -> None:
        self._out = out
        self._told_s: BoundedMap[str, float] = BoundedMap(NAMES_KEPT)

    def tell(self, atv: str, now_s: float) -> None:
        """A wish in this vehicle's name is not its own."""
        self._out.append(Ignore(ANOTHERS_KEY))
        told_s = self._told_s.get(atv)
        if told_s is not None and now_s - told_s < TOLD_EVERY_S:
            return
        self._told_s.pop(atv, None)
        self._told_s[atv] = now_s
        self._out.append(Record(NameMisused(atv)))
