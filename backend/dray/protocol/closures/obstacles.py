"""An agent's knowledge of obstacles on lanes: seen, reported, forgotten after a time, and looked at again."""

from __future__ import annotations

from collections.abc import Mapping

import msgspec

from dray.messages.floor.obstacle import FORGOTTEN_AT_MOST_S, FORGOTTEN_S, MOST, MOST_OF_ONE
from dray.plant.restrictions import Ends
from dray.protocol.runtime.events import NEVER_S

DOUBLED_AT_MOST = 16
"""Maximum doublings of the time for which an obstacle is remembered."""


class Known(msgspec.Struct, frozen=True):
    """One obstacle."""

    until_s: float
    """When it is forgotten (the agent's clock)."""
    by: str
    """The vehicle that has reported it."""


def lane_of(start: str, end: str) -> Ends:
    """The same name for both directions."""
    return (start, end) if start < end else (end, start)


class Obstacles:
    """The obstacles that one agent assumes."""

    def __init__(self) -> None:
        self._known: dict[Ends, Known] = {}
        self._times: dict[Ends, int] = {}
        """Sightings on a lane since it was last known to be free."""

    @property
    def known(self) -> Mapping[Ends, Known]:
        """All known obstacles, by lane (`lane_of`)."""
        return self._known

    @property
    def lanes(self) -> frozenset[Ends]:
        """The lanes with obstacles, in both directions."""
        return frozenset(ends for start, end in self._known for ends in ((start, end), (end, start)))

    @property
    def ends_s(self) -> float:
        """When the next obstacle is forgotten."""
        return min((known.until_s for known in self._known.values()), default=NEVER_S)

    def is_on(self, start: str, end: str) -> bool:
        """Whether there is a known obstacle here."""
        return lane_of(start, end) in self._known

    def meet(self, start: str, end: str, by: str, now_s: float) -> float:
        """Note an obstacle that this vehicle has seen. Returns how long it is remembered (s)."""
        lane = lane_of(start, end)
        times = self._times.get(lane, 0)
        self._times[lane] = times + 1
        for_s: float = min(FORGOTTEN_S * 2.0 ** min(times, DOUBLED_AT_MOST), FORGOTTEN_AT_MOST_S)
        self._known.pop(lane, None)
        self.on_reported(start, end, by, for_s, now_s)
        return for_s

    def on_reported(self, start: str, end: str, by: str, for_s: float, now_s: float) -> bool:
        """Note a reported obstacle; False if it is known, or its reporter has too many."""
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
        """Remove an obstacle; False if there was none."""
        lane = lane_of(start, end)
        self._times.pop(lane, None)
        return self._known.pop(lane, None) is not None

    def look(self, now_s: float) -> bool:
        """Forget old obstacles; True if there were any."""
        old = [lane for lane, known in self._known.items() if known.until_s <= now_s]
        for lane in old:
            del self._known[lane]
        return bool(old)
