"""Refusals: whose book is not copied, for it takes places from vehicles without their word. People are told when that goes on."""

from __future__ import annotations

from dray.messages.fact import BookRefused
from dray.protocol.runtime.events import Effect, Ignore, Record
from dray.protocol.runtime.throttle import Throttle

TAKES_PLACES = "a book that takes a place from a vehicle without its word"

REFUSED_OFTEN = 5
"""In a row, a second apart: a keeper that has started again may have lost the word of a vehicle, which is asked for it."""


class Refusals:
    """Of one agent's copies.

    Args:
        out: where effects go.
    """

    def __init__(self, out: list[Effect]) -> None:
        self._out = out
        self._throttle = Throttle()

    def tell(self, keeper: str, in_a_row: int, now_s: float) -> None:
        """A keeper's book was not copied, so often in a row."""
        self._out.append(Ignore(TAKES_PLACES))
        if in_a_row >= REFUSED_OFTEN and self._throttle.passes(keeper, now_s):
            self._out.append(Record(BookRefused(keeper)))
