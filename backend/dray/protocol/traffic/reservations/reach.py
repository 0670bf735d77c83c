"""What one vehicle may have of a district: a run of places round where it is heard to be, and nobody needs more.

A grant is cheap to ask for and dear to take back, since only its holder gives it back. So whoever has a certificate and says whatever it
likes takes as much floor as one vehicle does, and not the plant.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable
from math import dist

from dray.protocol.liveness.suspicion import gone_s
from dray.protocol.traffic.neighbours import Neighbours
from dray.protocol.traffic.places import Places

RUN_MAX = 16
"""Places of one vehicle in a district: twice what was seen in the search and on the floors of `dray bench traffic`, which is 7, and a little."""


class Reach:
    """Of all vehicles, as the leader of a reservation table knows them.

    Args:
        places: where they are.
        neighbours: where vehicles were heard to be.
        planned: the vehicles that the plant file knows.
    """

    def __init__(self, places: Places, neighbours: Neighbours, planned: Iterable[str]) -> None:
        self._places, self._neighbours = places, neighbours
        self._planned = frozenset(planned)

    def covers(self, atv: str, held: Collection[str], group: Iterable[str], now_s: float) -> bool:
        """Whether a vehicle may have a group of places beside those that it holds in the district.

        One of the plant file that has just come, and was not heard yet, may have the first group: it need not brake for its next heartbeat.

        Args:
            atv: the vehicle.
            held: what it holds in the district.
            group: what it would be granted.
            now_s: the present time.
        """
        wanted = {*held, *group}
        if len(wanted) > RUN_MAX:
            return False
        beat = self._neighbours.beat_of(atv)
        if beat is None or now_s - beat.at_s > gone_s(beat.every_s):
            return atv in self._planned and not held
        return self._is_within(beat.node, wanted, self._places.reach_m(now_s - beat.at_s))

    def may_hold(self, atv: str, holds: Collection[str], now_s: float) -> bool:
        """Whether a vehicle is believed that it holds these, where there is no reservation table to ask: a stranger only where it is heard to be."""
        if not holds or atv not in self._planned:
            return not holds or self.covers(atv, (), holds, now_s)
        return len(holds) <= RUN_MAX and self._is_within(
            next(iter(holds)), holds, 2.0 * self._places.reach_m(0.0)
        )

    def _is_within(self, node: str, places: Iterable[str], radius_m: float) -> bool:
        at_m = self._places.at_m
        here = at_m.get(self._places.place_of(node))
        return here is not None and all(dist(here, at_m[place]) <= radius_m for place in places)
