"""How long vehicles wait at a place beyond the handling itself (`dray.protocol.runtime.durations`).

What nobody has measured lately is no wait.
"""

from __future__ import annotations

from collections.abc import Iterable

from dray.messages import Wait
from dray.protocol.runtime.durations import Durations

QUANTILE = 0.8
"""A promise that four of five keep, before anything else is added to it."""

HALF_LIFE_S = 900.0
"""A refill, a shift's rush: what was so a quarter of an hour ago counts half."""

WAIT_MAX_S = 600.0
"""Longer than that nobody waits: it gives its task back."""


class Waits:
    """What one agent has learned of waits at places."""

    def __init__(self) -> None:
        self._durations = Durations(QUANTILE, HALF_LIFE_S, WAIT_MAX_S)

    def note(self, place: str, witness: str, waited_s: float, now_s: float) -> None:
        """Note how long a vehicle has waited at a place.

        Args:
            place: where.
            witness: who has told it; an empty name for what the agent has measured itself, all of which counts.
            waited_s: beyond the handling; what cannot be counts as the nearest that can.
            now_s: the present time.
        """
        self._durations.note(place, witness, waited_s, now_s)

    def expect_s(self, place: str, now_s: float) -> float:
        """How long the next one there will have to wait, most probably at most."""
        return self._durations.usual_s(place, now_s)

    def told(self, places: Iterable[str], now_s: float) -> tuple[Wait, ...]:
        """What others are told of these places: of those of which anything is known."""
        return tuple(
            Wait(place=place, wait_s=self.expect_s(place, now_s))
            for place in places
            if place in self._durations
        )
