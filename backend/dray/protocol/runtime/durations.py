"""Durations of recurring events, learned from recent measurements. Pure arithmetic.

    usual_s = the quantile of the last KEPT durations, each with the weight 1/2 ^ (age / half-life), and of one initial duration

Only the newest measurement of each witness counts. With at least three witnesses, a lying or unusual one moves the
figure no further than to the others' measurements.
"""

from __future__ import annotations

from collections import deque
from math import isfinite

from dray.protocol.runtime.bounded_map import BoundedMap

KEPT = 16
"""Measurements per subject: more than occur within a half-life."""

SUBJECTS_MAX = 256
"""Subjects: more than one agent deals with in a day."""


class Durations:
    """One agent's learned durations.

    Args:
        quantile: the fraction of events that last no longer.
        half_life_s: age at which a measurement counts half.
        longest_s: maximum duration that counts.
    """

    def __init__(self, quantile: float, half_life_s: float, longest_s: float) -> None:
        self._quantile = quantile
        self._half_life_s = half_life_s
        self._longest_s = longest_s
        self._noted: BoundedMap[str, deque[tuple[float, str, float]]] = BoundedMap(SUBJECTS_MAX)
        """By subject: time, witness and duration (s)."""

    def __contains__(self, subject: str) -> bool:
        return subject in self._noted

    def note(self, subject: str, witness: str, lasted_s: float, now_s: float) -> None:
        """Note a duration.

        Args:
            subject: the subject.
            witness: the reporting agent; empty for the agent's own measurements, which all count.
            lasted_s: the duration; an impossible value is clamped.
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
        """The expected duration, as an upper quantile (s).

        Args:
            subject: the subject.
            now_s: the present time.
            at_first_s: the initial value. It counts as one measurement made just now, so that a single experience
                has little weight.
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
