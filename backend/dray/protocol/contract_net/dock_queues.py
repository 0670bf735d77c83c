"""Expected vehicles at docks, as vehicles with right of way report them, and free times of docks. Pure arithmetic.

An agent that hires vehicles for a place receives their arrival times (`DockExpected`). It computes their order and
publishes it in its announcements; a bidder counts the vehicles before it. The changeover time of a dock is learned
from vehicles that were waiting when the one before them was done.

This is a hint: a vehicle that is not where it said makes other promises worse, and blocks nobody. Only the newest
report of each vehicle about a place counts, and no stay of more than STAY_MAX_S.
"""

from __future__ import annotations

from collections.abc import Iterable

from dray.messages import DockExpected, DockTime
from dray.messages.contract import DOCK_TIMES_MAX
from dray.protocol.runtime.bounded_map import BoundedMap

STAY_MAX_S = 120.0
"""Maximum stay that counts (s): a slow handling."""

AHEAD_MAX_S = 1800.0
"""Maximum time ahead (s): no way is longer."""

GONE_AFTER_S = 120.0
"""Time after which an overdue vehicle is dropped (s): it does something else, or its report was lost."""

TURN_S, TURN_MAX_S = 12.0, 60.0
"""Time from one vehicle's end to the next one's docking (s): initial value, and maximum that counts as a changeover."""

SOON_S = 2.5
"""Arrival times closer than this have no sure order (s): about the accuracy of foreseen ways to a dock."""

TURN_GAIN = 0.3
"""Weight of the newest turn."""

DOCKS_MAX = 256
"""Maximum docks: more than one agent deals with in an hour."""

VEHICLES_MAX = 64
"""Maximum expected vehicles per dock: more than can come in an hour."""


class _Dock:
    """What is known of one dock."""

    __slots__ = ("done_s", "expected", "turn_s")

    def __init__(self) -> None:
        self.expected: dict[str, DockExpected] = {}
        self.turn_s = TURN_S
        self.done_s = float("-inf")
        """When the last vehicle was done there (plant clock, s)."""

    def note(self, atv: str, said: DockExpected, now_s: float) -> None:
        """A vehicle has reported its arrival time, its docking, or its end."""
        before = self.expected.pop(atv, None)
        if not said.stays_s:
            self.done_s = now_s
            return
        if said.docked and before is not None and before.comes_s <= self.done_s >= now_s - TURN_MAX_S:
            self.turn_s += TURN_GAIN * (now_s - self.done_s - self.turn_s)
        self.expected[atv] = said
        while len(self.expected) > VEHICLES_MAX:
            del self.expected[next(iter(self.expected))]

    def times(self, now_s: float, besides: str = "") -> Iterable[DockTime]:
        """The vehicles' times at the dock in their order, without `besides`."""
        free_s = float("-inf")
        for atv, said in sorted(
            self.expected.items(), key=lambda each: (not each[1].docked, each[1].comes_s)
        ):
            begins_s = said.comes_s if said.docked else max(said.comes_s, free_s, now_s)
            done_s = max(begins_s + said.stays_s, now_s)
            if atv == besides or said.comes_s + said.stays_s + GONE_AFTER_S < now_s:
                continue
            free_s = max(free_s, done_s + self.turn_s)
            yield DockTime(atv=atv, comes_s=said.comes_s, leaves_s=free_s)


class DockQueues:
    """One agent's knowledge of docks."""

    def __init__(self) -> None:
        self._docks: BoundedMap[str, _Dock] = BoundedMap(DOCKS_MAX)

    def on_expected(self, sender: str, said: DockExpected, now_s: float) -> None:
        """Handle a vehicle's report of a place; an impossible one is ignored."""
        if not 0.0 <= said.stays_s <= STAY_MAX_S or said.comes_s > now_s + AHEAD_MAX_S:
            return
        dock = self._docks.get(said.place)
        if dock is None:
            dock = self._docks[said.place] = _Dock()
        dock.note(sender, said, now_s)

    def __bool__(self) -> bool:
        """Whether any vehicle reports arrival times: vehicles that occupy space do."""
        return len(self._docks) > 0

    def of(self, place: str, atv: str) -> DockExpected | None:
        """A vehicle's report of itself at a place; None if there is none, or it is done there."""
        dock = self._docks.get(place)
        return None if dock is None else dock.expected.get(atv)

    def wait_s(self, place: str, comes_s: float, atv: str, now_s: float) -> float:
        """How long a vehicle that arrives at `comes_s` will wait before a place (s)."""
        dock = self._docks.get(place)
        return 0.0 if dock is None else wait_s(dock.times(now_s, atv), comes_s, atv)

    def told(self, place: str, now_s: float) -> tuple[DockTime, ...]:
        """Dock times for bidders: the next vehicles at a place, and when the dock is free again."""
        dock = self._docks.get(place)
        return () if dock is None else tuple(dock.times(now_s))[:DOCK_TIMES_MAX]


def wait_s(times: Iterable[DockTime], comes_s: float, me: str) -> float:
    """How long a vehicle will wait before a dock, behind all that come before it or with it (s).

    Args:
        times: the announcement's dock times.
        comes_s: arrival time (plant clock).
        me: the vehicle's own id; its own report does not count.
    """
    free_s = (time.leaves_s for time in times if time.atv != me and time.comes_s <= comes_s + SOON_S)
    return max(max(free_s, default=comes_s) - comes_s, 0.0)
