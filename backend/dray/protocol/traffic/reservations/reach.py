"""What one vehicle may hold in a district: a run of places round its last reported position; no vehicle needs more.

A grant is cheap to get and hard to take back, since only its holder releases it. With this limit a liar with a certificate blocks
as much floor as one vehicle does, and not the plant.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable
from math import dist

from dray.protocol.liveness.suspicion import gone_s
from dray.protocol.traffic.neighbours import Neighbours
from dray.protocol.traffic.places import Places

RUN_MAX = 16
"""Maximum places of one vehicle in a district: a little more than twice the 7 that were seen in the search (`dray_sim.explore`) and
in `dray bench traffic`."""


class Reach:
    """The reach of all vehicles, as the leader of a reservation table knows them.

    Args:
        places: their positions.
        neighbours: the vehicles' reported positions.
        planned: the vehicles of the plant file.
    """

    def __init__(self, places: Places, neighbours: Neighbours, planned: Iterable[str]) -> None:
        self._places, self._neighbours = places, neighbours
        self._planned = frozenset(planned)

    def covers(self, atv: str, held: Collection[str], group: Iterable[str], now_s: float) -> bool:
        """Whether a vehicle may have a group of places beside those that it holds in the district.

        A vehicle of the plant file that was not heard yet may have its first group, so that it need not brake until its heartbeat.

        Args:
            atv: the vehicle.
            held: what it holds in the district.
            group: the further places.
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
        """Whether a vehicle's claim to places is believed when no table knows; a vehicle outside the plant file must be near them."""
        if not holds or atv not in self._planned:
            return not holds or self.covers(atv, (), holds, now_s)
        return len(holds) <= RUN_MAX and self._is_within(
            next(iter(holds)), holds, 2.0 * self._places.reach_m(0.0)
        )

    def _is_within(self, node: str, places: Iterable[str], radius_m: float) -> bool:
        at_m = self._places.at_m
        here = at_m.get(self._places.place_of(node))
        return here is not None and all(dist(here, at_m[place]) <= radius_m for place in places)
