"""Vehicles' waiting times at a place beyond the handling itself (`dray.protocol.runtime.durations`).

A place without recent measurements has no wait.
"""

from __future__ import annotations

from collections.abc import Iterable

from dray.messages import Wait
from dray.protocol.runtime.durations import Durations

QUANTILE = 0.8
"""Four of five vehicles keep such a promise, before any slack."""

HALF_LIFE_S = 900.0
"""A refill, or a shift's rush: a quarter of an hour halves a measurement's weight."""

WAIT_MAX_S = 600.0
"""Maximum wait (s): a vehicle gives its task back then."""


class Waits:
    """One agent's knowledge of waits at places."""

    def __init__(self) -> None:
        self._durations = Durations(QUANTILE, HALF_LIFE_S, WAIT_MAX_S)

    def note(self, place: str, witness: str, waited_s: float, now_s: float) -> None:
        """Note a vehicle's wait at a place.

        Args:
            place: the place.
            witness: the reporting agent; empty for the agent's own measurements, which all count.
            waited_s: beyond the handling; an impossible value is clamped.
            now_s: the present time.
        """
        self._durations.note(place, witness, waited_s, now_s)

    def expect_s(self, place: str, now_s: float) -> float:
        """Expected wait of the next vehicle there, as an upper quantile (s)."""
        return self._durations.usual_s(place, now_s)

    def told(self, places: Iterable[str], now_s: float) -> tuple[Wait, ...]:
        """Known waits at these places, for other agents."""
        return tuple(
            Wait(place=place, wait_s=self.expect_s(place, now_s))
            for place in places
            if place in self._durations
        )
