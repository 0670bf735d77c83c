"""Gaps: which numbers of agents' histories have not arrived."""

from __future__ import annotations

from collections.abc import Mapping

MISSING_PER_AGENT = 1_000
"""Numbers remembered one by one, to see them arrive late; beyond that they are only counted."""


class Gaps:
    """Watches the numbers of every agent's newest incarnation.

    Args:
        last: per agent the incarnation and highest number that are known already.
    """

    def __init__(self, last: Mapping[str, tuple[int, int]] | None = None) -> None:
        self._last = dict(last or {})
        self._missing: dict[str, set[int]] = {}
        self.missing = 0
        """How many numbers were skipped and have not come since, over all agents."""

    def note(self, agent: str, incarnation: int, number: int) -> None:
        """An event has arrived; doubled and late ones are normal."""
        known, last = self._last.get(agent, (0, 0))
        if incarnation < known:
            return
        if incarnation > known:
            self._missing.pop(agent, None)
            last = 0
        if number > last:
            self._skipped(agent, last + 1, number)
            self._last[agent] = (incarnation, number)
        elif number in (late := self._missing.get(agent, set())):
            late.remove(number)
            self.missing -= 1

    def _skipped(self, agent: str, first: int, end: int) -> None:
        if first == end:
            return
        self.missing += end - first
        numbers = self._missing.setdefault(agent, set())
        room = MISSING_PER_AGENT - len(numbers)
        numbers.update(range(max(first, end - room), end))
