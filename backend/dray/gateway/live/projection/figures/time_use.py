"""How agents spend their time, by their last message; exact, at a cost that does not grow with time.

An agent does what it last said until it says something else, while it counts as alive. After that its time is
`SILENT`, until it is heard again.
"""

from __future__ import annotations

from collections.abc import Iterable

from dray.gateway.live.projection.figures.sliding_window import Window
from dray.protocol.liveness.suspicion import IDLE_INTERVAL_S, MISSES

SILENCE_S = MISSES * IDLE_INTERVAL_S
"""Factory seconds after its last message for which an agent is believed: three times the slowest interval."""

HOUR_SLOTS = (60.0, 60)
"""One hour of factory time, by minutes: slot length in seconds, and number of slots."""

SILENT = "silent"


class _Spell:
    """The present activity of one agent."""

    __slots__ = ("counted_s", "heard_s", "what")

    def __init__(self, what: str, heard_s: float) -> None:
        self.what = what
        self.heard_s = heard_s
        self.counted_s = heard_s
        """Its time is counted up to here."""


class TimeUse:
    """Time per activity over all agents of one kind. All times are factory seconds.

    Args:
        doings: all activities of an agent, except being silent.
        lasting: the activity that goes on while the agent is silent.

    Attributes:
        totals_s: per activity, since the beginning. Their sum grows by one second per second and agent.
    """

    def __init__(self, doings: Iterable[str], lasting: str = "") -> None:
        self._lasting = lasting
        self.totals_s = dict.fromkeys((*doings, SILENT), 0.0)
        self._hour = {doing: Window(*HOUR_SLOTS) for doing in self.totals_s}
        self._spells: dict[str, _Spell] = {}
        """By agent; bounded because only admitted agents are counted."""

    def tell(self, agent: str, doing: str, at_s: float) -> None:
        """Note an agent's activity; the time up to now counts for its previous one."""
        spell = self._spells.get(agent)
        if spell is None:
            self._spells[agent] = _Spell(doing, at_s)
            return
        if spell.counted_s < at_s <= spell.heard_s + SILENCE_S:
            # The usual case, with the same result as `_count`.
            spent_s = at_s - spell.counted_s
            self.totals_s[spell.what] += spent_s
            self._hour[spell.what].add(at_s, spent_s)
            spell.counted_s = at_s
        else:
            self._count(spell, at_s)
        spell.what = doing
        spell.heard_s = max(spell.heard_s, at_s)

    def settle(self, now_s: float) -> None:
        """Count every agent's time up to now, also of silent ones."""
        for spell in self._spells.values():
            self._count(spell, now_s)

    def hour_s(self, doing: str, now_s: float) -> float:
        """Seconds counted for this activity in the last hour."""
        (spent_s,) = self._hour[doing].sums(now_s, 1)
        return spent_s

    def hour(self, now_s: float) -> dict[str, float]:
        """Fractions of the last hour, by activity; empty when nothing is counted."""
        spent_s = {doing: self.hour_s(doing, now_s) for doing in self._hour}
        total_s = sum(spent_s.values())
        return {doing: each_s / total_s for doing, each_s in spent_s.items()} if total_s > 0 else {}

    def _count(self, spell: _Spell, until_s: float) -> None:
        believed_s = until_s if spell.what == self._lasting else min(until_s, spell.heard_s + SILENCE_S)
        if believed_s > spell.counted_s:
            self._spend(spell.what, believed_s, believed_s - spell.counted_s)
            spell.counted_s = believed_s
        if until_s > spell.counted_s:
            self._spend(SILENT, until_s, until_s - spell.counted_s)
            spell.counted_s = until_s

    def _spend(self, doing: str, at_s: float, spent_s: float) -> None:
        self.totals_s[doing] += spent_s
        self._hour[doing].add(at_s, spent_s)
