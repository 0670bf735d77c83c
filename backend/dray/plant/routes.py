"""Shortest ways for one type of vehicle: the hot path of every bid.

A way is the one with the least lane time (length over the lower of lane limit and vehicle speed);
among equals the one that goes straight on, because every bend costs a vehicle its speed, and then
the first in file order. The duration of a way, once chosen, is that of the real motion.

One search backwards from a goal answers for all starts. It is done when a goal is first asked for
and kept as one array of floats; finished ways are kept as well, so that a second question costs
two dictionary lookups.
"""

from __future__ import annotations

from array import array
from collections.abc import Iterable, Mapping, Sequence
from heapq import heappop, heappush
from math import inf

import msgspec

from dray.errors import NoWay
from dray.plant.model import VehicleType
from dray.plant.motion import way_s
from dray.plant.roads import DirectedLane, Roads, bends

MAX_WAYS = 250_000
"""Ways kept per vehicle type, about 100 MB in the largest plants; then all are dropped and found anew."""

_SLACK_S = 1e-9
"""Two sums of the same lanes in another order may differ by this; real lanes never do."""


class Way(msgspec.Struct, frozen=True, gc=False):
    """How to get from one node to another."""

    nodes: tuple[str, ...]
    """From the start to the goal, both included; a single one where they are the same."""
    length_m: float
    duration_s: float
    """From standstill to standstill with nobody in the way."""


class _Step(msgspec.Struct, frozen=True, gc=False):
    """A lane as the search sees it."""

    lane: DirectedLane
    start: int
    end: int
    lane_s: float
    """At the lane's limit or the vehicle's own top speed, whichever is lower."""


class Routes:
    """Ways of one type of vehicle through a plant. Deterministic; grows its memory as it is asked.

    Args:
        roads: the plant's network.
        vehicle: the type of vehicle.
        places: place id -> node id, for `nearest`.
    """

    __slots__ = ("_entering", "_found", "_index", "_kept", "_leaving", "_left_s", "_places", "_vehicle")

    def __init__(self, roads: Roads, vehicle: VehicleType, places: Mapping[str, str]) -> None:
        self._vehicle = vehicle
        self._places = places
        self._index = {node: index for index, node in enumerate(roads.leaving)}
        steps = {(lane.start, lane.end): self._step(lane) for lane in roads.lanes}
        self._leaving = [[steps[lane.start, lane.end] for lane in lanes] for lanes in roads.leaving.values()]
        self._entering = [
            [(step.start, step.lane_s) for step in (steps[lane.start, lane.end] for lane in lanes)]
            for lanes in roads.entering.values()
        ]
        self._left_s: dict[str, Sequence[float]] = {}
        self._found: dict[str, dict[str, Way]] = {}
        self._kept = 0

    def way(self, start_node: str, goal_node: str) -> Way:
        """The way from one node to another.

        Raises:
            NoWay: no lanes lead there, or one of the two is no node of this plant.
        """
        try:
            return self._found[goal_node][start_node]
        except KeyError:
            return self._find(start_node, goal_node)

    def duration_s(self, start_node: str, goal_node: str) -> float:
        """Seconds from standstill at one node to standstill at the other; raises as `way`."""
        try:
            return self._found[goal_node][start_node].duration_s
        except KeyError:
            return self._find(start_node, goal_node).duration_s

    def length_m(self, start_node: str, goal_node: str) -> float:
        """Metres to drive from one node to the other; raises as `way`."""
        try:
            return self._found[goal_node][start_node].length_m
        except KeyError:
            return self._find(start_node, goal_node).length_m

    def nearest(self, start_node: str, places: Iterable[str]) -> tuple[str, Way]:
        """The place of `places` that is reached first, and the way there.

        Args:
            start_node: where the vehicle stands.
            places: ids of machines, storages, warehouses, chargers or parking places; of equally
                near ones the first wins.

        Raises:
            NoWay: none of them can be reached.
        """
        best: tuple[str, Way] | None = None
        for place in places:
            try:
                way = self.way(start_node, self._places[place])
            except NoWay:
                continue
            if best is None or way.duration_s < best[1].duration_s:
                best = place, way
        if best is None:
            raise NoWay(start_node, "any of the places asked for")
        return best

    def _step(self, lane: DirectedLane) -> _Step:
        top_mps = min(lane.speed_limit_mps, self._vehicle.max_speed_mps)
        return _Step(lane, self._index[lane.start], self._index[lane.end], lane.length_m / top_mps)

    def _find(self, start_node: str, goal_node: str) -> Way:
        """Find a way that is not known yet, and keep it."""
        here, goal = self._index.get(start_node), self._index.get(goal_node)
        if here is None or goal is None:
            raise NoWay(start_node, goal_node)
        left_s = self._left_s.get(goal_node)
        if left_s is None:
            left_s = self._left_s[goal_node] = self._search(goal)
        if left_s[here] == inf:
            raise NoWay(start_node, goal_node)
        lanes = self._follow(here, goal, left_s)
        way = Way(
            (start_node, *(lane.end for lane in lanes)),
            sum(lane.length_m for lane in lanes),
            way_s(lanes, self._vehicle),
        )
        if self._kept >= MAX_WAYS:
            self._found.clear()
            self._kept = 0
        self._found.setdefault(goal_node, {})[start_node] = way
        self._kept += 1
        return way

    def _search(self, goal: int) -> Sequence[float]:
        """Least lane time from every node to `goal` in seconds, infinite where no way leads there."""
        left_s = [inf] * len(self._index)
        left_s[goal] = 0.0
        frontier = [(0.0, goal)]
        while frontier:
            so_far_s, node = heappop(frontier)
            if so_far_s > left_s[node]:
                continue
            for before, lane_s in self._entering[node]:
                through_s = so_far_s + lane_s
                if through_s < left_s[before]:
                    left_s[before] = through_s
                    heappush(frontier, (through_s, before))
        return array("d", left_s)

    def _follow(self, here: int, goal: int, left_s: Sequence[float]) -> list[DirectedLane]:
        """The lanes from `here` to `goal` along the least lane time, straight on where there is a choice."""
        lanes: list[DirectedLane] = []
        while here != goal:
            bound_s = left_s[here] + _SLACK_S
            best = [step for step in self._leaving[here] if step.lane_s + left_s[step.end] <= bound_s]
            # Only ever forward: with lanes shorter than the slack a vehicle would drive in circles.
            best = [step for step in best if left_s[step.end] < left_s[here]]
            step = next((step for step in best if lanes and not bends(lanes[-1], step.lane)), best[0])
            lanes.append(step.lane)
            here = step.end
        return lanes
