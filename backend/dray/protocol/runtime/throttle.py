"""A throttle: at most one report per name and minute, so that no sender fills a history."""

from __future__ import annotations

from dray.protocol.runtime.bounded_map import BoundedMap

TOLD_EVERY_S = 60.0
"""Minimum interval of reports per name (s): people look once a minute at most, and software needs no more."""

NAMES_KEPT = 1024
"""Maximum names: more than any agent hears; a forgotten one is reported once more."""


class Throttle:
    """A throttle of one kind of report, by name."""

    def __init__(self) -> None:
        self._told_s: BoundedMap[str, float] = BoundedMap(NAMES_KEPT)

    def passes(self, name: str, now_s: float) -> bool:
        """Whether a name may be reported now; if so, that is noted. A clock that was set back blocks nothing."""
        told_s = self._told_s.pop(name, None)
        passes = told_s is None or not 0.0 <= now_s - told_s < TOLD_EVERY_S
        self._told_s[name] = now_s if told_s is None or passes else told_s
        return passes
