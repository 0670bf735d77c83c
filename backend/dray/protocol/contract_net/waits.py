"""How long vehicles wait at a place beyond the handling itself: learned from what was measured lately. Pure arithmetic.

    expect_s = the QUANTILE of the last waits there, each with the weight 1/2 ^ (age / HALF_LIFE_S), and of one wait of nothing

What nobody has measured lately is no wait. Of each witness only its newest counts, so one that lies, or has waited for a
reason of its own, moves the figure no further than to what others have seen, as soon as there are three of them; no wait
counts for more than WAIT_MAX_S, whoever tells it.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from math import isfinite

from dray.messages import Wait
from dray.protocol.runtime.bounded_map import BoundedMap

QUANTILE = 0.8
"""A promise that four of five keep, before anything else is added to it."""

HALF_LIFE_S = 900.0
"""A refill, a shift's rush: what was so a quarter of an hour ago counts half."""

WAIT_MAX_S = 600.0
"""Longer than that nobody waits: it gives its task back."""

KEPT = 16
"""Waits of one place: more than a dock sees in a quarter of an hour of which each counts."""

PLACES_MAX = 256
"""Places: more than one agent has to do with in a day."""


class Waits:
    """What one agent has learned of waits at places."""

    def __init__(self) -> None:
        self._noted: BoundedMap[str, deque[tuple[float, str, float]]] = BoundedMap(PLACES_MAX)
        """Per place: when, who has seen it, and how long it was (s)."""

    def note(self, place: str, witness: str, waited_s: float, now_s: float) -> None:
        """Note how long a vehicle has waited at a place.

        Args:
            place: where.
            witness: who has told it; an empty name for what the agent has measured itself, all of which counts.
            waited_s: beyond the handling; what cannot be counts as the nearest that can.
            now_s: the present time.
        """
        if not isfinite(waited_s):
            return
        noted = self._noted.get(place)
        if noted is None:
            noted = self._noted[place] = deque(maxlen=KEPT)
        if witness:
            kept = [each for each in noted if each[1] != witness]
            noted.clear()
            noted.extend(kept)
        noted.append((now_s, witness, min(max(waited_s, 0.0), WAIT_MAX_S)))

    def expect_s(self, place: str, now_s: float) -> float:
        """How long the next one there will have to wait, most probably at most."""
        noted = self._noted.get(place)
        if not noted:
            return 0.0
        weighed = sorted((wait_s, 0.5 ** ((now_s - at_s) / HALF_LIFE_S)) for at_s, _, wait_s in noted)
        # One wait of nothing is known of every place: a single bad experience is none to count on for long.
        total = 1.0 + sum(weight for _, weight in weighed)
        reached, expected_s = 1.0, 0.0
        for wait_s, weight in weighed:
            if reached >= QUANTILE * total:
                break
            reached, expected_s = reached + weight, wait_s
        return expected_s

    def told(self, places: Iterable[str], now_s: float) -> tuple[Wait, ...]:
        """What others are told of these places: of those of which anything is known."""
        return tuple(
            Wait(place=place, wait_s=self.expect_s(place, now_s)) for place in places if place in self._noted
        )
