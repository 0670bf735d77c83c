"""How long something lasts that happens again and again: learned from what was measured lately. Pure arithmetic.

    usual_s = the quantile of the last KEPT times, each with the weight 1/2 ^ (age / half-life), and of one time to begin with

Of each witness only its newest counts, so one that lies, or had a reason of its own, moves the figure no further than to
what others have seen, as soon as there are three of them.
"""

from __future__ import annotations

from collections import deque
from math import isfinite

from dray.protocol.runtime.bounded_map import BoundedMap

KEPT = 16
"""Times of one subject: more than there are within a half-life."""

SUBJECTS_MAX = 256
"""More than one agent has to do with in a day."""


class Durations:
    """What one agent has learned of how long things last.

    Args:
        quantile: so many, as a part of all, last no longer.
        half_life_s: what was so that long ago counts half.
        longest_s: nothing counts for more, whoever tells it.
    """

    def __init__(self, quantile: float, half_life_s: float, longest_s: float) -> None:
        self._quantile = quantile
        self._half_life_s = half_life_s
        self._longest_s = longest_s
        self._noted: BoundedMap[str, deque[tuple[float, str, float]]] = BoundedMap(SUBJECTS_MAX)
        """Per subject: when, who has seen it, and how long it was (s)."""

    def __contains__(self, subject: str) -> bool:
        return subject in self._noted

    def note(self, subject: str, witness: str, lasted_s: float, now_s: float) -> None:
        """Note how long it has lasted.

        Args:
            subject: what.
            witness: who has told it; an empty name for what the agent has measured itself, all of which counts.
            lasted_s: what cannot be counts as the nearest that can.
            now_s: the present time.
        """
        if not isfinite(lasted_s):
            return
        noted = self._noted.get(subject)
        if noted is None:
            noted = self._noted[subject] = deque(maxlen=KEPT)
        if witness:
            kept = [each for each in noted if each[1] != witness]
            noted.clear()
            noted.extend(kept)
        noted.append((now_s, witness, min(max(lasted_s, 0.0), self._longest_s)))

    def usual_s(self, subject: str, now_s: float, at_first_s: float = 0.0) -> float:
        """How long it will last, most probably at most.

        Args:
            subject: what.
            now_s: the present time.
            at_first_s: what is believed while nothing is known; it goes on counting as one time that was measured just now, so that
                a single experience is none to count on for long.
        """
        noted = self._noted.get(subject)
        if not noted:
            return at_first_s
        weighed = [(lasted_s, 0.5 ** ((now_s - at_s) / self._half_life_s)) for at_s, _, lasted_s in noted]
        total = 1.0 + sum(weight for _, weight in weighed)
        weighed.append((at_first_s, 1.0))
        weighed.sort()
        reached, usual_s = 0.0, at_first_s
        for lasted_s, weight in weighed:
            if reached >= self._quantile * total:
                break
            reached, usual_s = reached + weight, lasted_s
        return usual_s
