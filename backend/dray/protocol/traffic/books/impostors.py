"""Impostors: who speaks in the name of a vehicle that holds places, and has not its key. Its wishes change nothing; people are told."""

from __future__ import annotations

from dray.messages.fact import NameMisused
from dray.protocol.runtime.events import Effect, Ignore, Record
from dray.protocol.runtime.throttle import Throttle

ANOTHERS_KEY = "a wish that is not signed by the vehicle that holds places in this name"


class Impostors:
    """Of one agent's books.

    Args:
        out: where effects go.
    """

    def __init__(self, out: list[Effect]) -> None:
        self._out = out
        self._throttle = Throttle()

    def tell(self, atv: str, now_s: float) -> None:
        """A wish in this vehicle's name is not its own."""
        self._out.append(Ignore(ANOTHERS_KEY))
        if self._throttle.passes(atv, now_s):
            self._out.append(Record(NameMisused(atv)))
