"""Who is expected at docks, as vehicles with right of way tell, and when the next one can be there. Pure arithmetic.

Whoever hires vehicles for a place hears when they come (`DockExpected`), works out how they will follow one another, and tells that in
its announcements; a bidder counts whoever comes before it. How long a dock takes from one vehicle to the next is learned from vehicles
that were waiting when the one before them was done.

A hint: whoever is not where it said to be makes others' promises worse, and holds nobody up. Of each vehicle only its newest word about
a place counts, and no stay of more than STAY_MAX_S.
"""

from __future__ import annotations

from collections.abc import Iterable

from dray.messages import DockExpected, DockTime
from dray.messages.contract import DOCK_TIMES_MAX
from dray.protocol.runtime.bounded_map import BoundedMap

STAY_MAX_S = 120.0
"""Nobody counts for longer, however long it says to stay: a slow handling."""

AHEAD_MAX_S = 1800.0
"""Nobody is counted on earlier: no way is longer."""

GONE_AFTER_S = 120.0
"""One that should have left so long ago has done something else, or its word was lost."""

TURN_S, TURN_MAX_S = 12.0, 60.0
"""From one vehicle that is done to the next one that stands at the dock: what nobody has seen yet, and what is no turn any more."""

SOON_S = 2.5
"""Of two that come within so little of one another either may be the first: about what ways to a dock are foreseen to."""

TURN_GAIN = 0.3
"""Weight of the newest turn."""

DOCKS_MAX = 256
"""Docks: more than one agent has to do with in an hour."""

VEHICLES_MAX = 64
"""Vehicles that are expected at one dock: more than can be there in an hour."""


class _Dock:
    """What is known of one dock."""

    __slots__ = ("done_s", "expected", "turn_s")

    def __init__(self) -> None:
        self.expected: dict[str, DockExpected] = {}
        self.turn_s = TURN_S
        self.done_s = float("-inf")
        """When the last one was done there."""

    def note(self, atv: str, said: DockExpected, now_s: float) -> None:
        """A vehicle has told when it will be there, that it is, or that it is done."""
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
        """Who is there when, one behind the other; `besides` is not among them."""
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
    """What one agent that hires vehicles knows of docks."""

    def __init__(self) -> None:
        self._docks: BoundedMap[str, _Dock] = BoundedMap(DOCKS_MAX)

    def on_expected(self, sender: str, said: DockExpected, now_s: float) -> None:
        """A vehicle tells of a place; what cannot be counts for nothing."""
        if not 0.0 <= said.stays_s <= STAY_MAX_S or said.comes_s > now_s + AHEAD_MAX_S:
            return
        dock = self._docks.get(said.place)
        if dock is None:
            dock = self._docks[said.place] = _Dock()
        dock.note(sender, said, now_s)

    def __bool__(self) -> bool:
        """Whether any vehicle tells when it comes: they do where they take up room."""
        return len(self._docks) > 0

    def of(self, place: str, atv: str) -> DockExpected | None:
        """What a vehicle has told of itself at a place; None where it has not, or is done there."""
        dock = self._docks.get(place)
        return None if dock is None else dock.expected.get(atv)

    def wait_s(self, place: str, comes_s: float, atv: str, now_s: float) -> float:
        """How long a vehicle that comes at a time will stand before a place, behind all others."""
        dock = self._docks.get(place)
        return 0.0 if dock is None else wait_s(dock.times(now_s, atv), comes_s, atv)

    def told(self, place: str, now_s: float) -> tuple[DockTime, ...]:
        """What bidders are told of a place: who is there next, and when the dock is free again."""
        dock = self._docks.get(place)
        return () if dock is None else tuple(dock.times(now_s))[:DOCK_TIMES_MAX]


def wait_s(times: Iterable[DockTime], comes_s: float, me: str) -> float:
    """How long a vehicle will stand before a dock: behind all that come before it, or with it.

    Args:
        times: as they were told with the announcement.
        comes_s: when it would be there (plant clock).
        me: the vehicle: its own word does not count.
    """
    free_s = (time.leaves_s for time in times if time.atv != me and time.comes_s <= comes_s + SOON_S)
    return max(max(free_s, default=comes_s) - comes_s, 0.0)
