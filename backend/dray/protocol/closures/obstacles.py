"""What an agent knows of things that lie on lanes: seen, told, forgotten after a time, and looked at again."""

from __future__ import annotations

from collections.abc import Mapping

import msgspec

from dray.messages.floor.obstacle import FORGOTTEN_AT_MOST_S, FORGOTTEN_S, MOST, MOST_OF_ONE
from dray.plant.restrictions import Ends
from dray.protocol.runtime.events import NEVER_S

DOUBLED_AT_MOST = 16
"""Times that an obstacle is counted on for twice as long as before."""


class Known(msgspec.Struct, frozen=True):
    """One obstacle."""

    until_s: float
    """When it is forgotten (the agent's clock)."""
    by: str
    """Who has told of it."""


def lane_of(start: str, end: str) -> Ends:
    """One name for both directions."""
    return (start, end) if start < end else (end, start)


class Obstacles:
    """The obstacles that one agent counts on."""

    def __init__(self) -> None:
        self._known: dict[Ends, Known] = {}
        self._times: dict[Ends, int] = {}
        """How often something was seen on a lane, since it was last known to be free."""

    @property
    def known(self) -> Mapping[Ends, Known]:
        """All of them, by lane (`lane_of`)."""
        return self._known

    @property
    def lanes(self) -> frozenset[Ends]:
        """The lanes, both directions of each."""
        return frozenset(ends for start, end in self._known for ends in ((start, end), (end, start)))

    @property
    def ends_s(self) -> float:
        """When the next one is forgotten."""
        return min((known.until_s for known in self._known.values()), default=NEVER_S)

    def is_on(self, start: str, end: str) -> bool:
        """Whether one is counted on here."""
        return lane_of(start, end) in self._known

    def meet(self, start: str, end: str, by: str, now_s: float) -> float:
        """Something was seen by this vehicle itself. Returns for how long it is to be counted on."""
        lane = lane_of(start, end)
        times = self._times.get(lane, 0)
        self._times[lane] = times + 1
        for_s: float = min(FORGOTTEN_S * 2.0 ** min(times, DOUBLED_AT_MOST), FORGOTTEN_AT_MOST_S)
        self._known.pop(lane, None)
        self.on_reported(start, end, by, for_s, now_s)
        return for_s

    def on_reported(self, start: str, end: str, by: str, for_s: float, now_s: float) -> bool:
        """Something was seen; False when that changes nothing, or its speaker has told of too many."""
        lane = lane_of(start, end)
        known = self._known.get(lane)
        if known is None:
            of_one = sum(other.by == by for other in self._known.values())
            if len(self._known) >= MOST or of_one >= MOST_OF_ONE:
                return False
        until_s = now_s + min(for_s, FORGOTTEN_AT_MOST_S)
        if known is not None and known.until_s >= until_s:
            return False
        self._known[lane] = Known(until_s, by)
        return known is None

    def clear(self, start: str, end: str) -> bool:
        """It is gone; False when none was counted on."""
        lane = lane_of(start, end)
        self._times.pop(lane, None)
        return self._known.pop(lane, None) is not None

    def look(self, now_s: float) -> bool:
        """Forget what is old; True when there was something."""
        old = [lane for lane, known in self._known.items() if known.until_s <= now_s]
        for lane in old:
            del self._known[lane]
        return bool(old)
