"""A throttle: what is told of each name once a minute at most, so that nobody who goes on and on fills anybody's history."""

from __future__ import annotations

from dray.protocol.runtime.bounded_map import BoundedMap

TOLD_EVERY_S = 60.0
"""People look once a minute at most, and a software that could do something about it needs no more."""

NAMES_KEPT = 1024
"""More than any agent hears; one that is forgotten is told of once more."""


class Throttle:
    """Of one thing that is told, by name."""

    def __init__(self) -> None:
        self._told_s: BoundedMap[str, float] = BoundedMap(NAMES_KEPT)

    def passes(self, name: str, now_s: float) -> bool:
        """Whether it is to be told of a name now; then it is noted. A clock that was set back holds nothing up."""
        told_s = self._told_s.pop(name, None)
        passes = told_s is None or not 0.0 <= now_s - told_s < TOLD_EVERY_S
        self._told_s[name] = now_s if told_s is None or passes else told_s
        return passes
