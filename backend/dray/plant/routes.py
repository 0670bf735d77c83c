"""Shortest ways for one type of vehicle: the hot path of every bid.

A way is the one with the least lane time (length over the lower of lane limit and vehicle speed, and the opening time
of a door). Among equals it goes straight on, because every bend costs a vehicle its speed; then the first in file
order wins. The duration of a way, once chosen, is that of the real motion.

One search backwards from a goal answers for all starts. The search goes as far as a question needs, and is kept
(`lane_times`). Finished ways are kept as well, so that a second question costs two dictionary lookups.
"""

from __future__ import annotations

from collections.abc import Container, Iterable, Mapping
from contextlib import suppress
from heapq import heappop, heappush
from math import inf

import msgspec

from dray.errors import NoWay
from dray.plant.floor.motion import Run, joint_mps, limit_mps, runs_s
from dray.plant.floor.motion import lane_s as lane_time_s
from dray.plant.lane_times import LaneTimes
from dray.plant.model import VehicleType
from dray.plant.restrictions import OPEN, Restrictions
from dray.plant.roads import DirectedLane, Roads, bends

MAX_WAYS = 250_000
"""Ways kept per vehicle type, about 100 MB in the largest plants; then all are dropped and found anew."""

MAX_NEAREST = 10_000
"""Kept answers of `nearest`, then all are dropped: each agent asks for the chargers nearest to the nodes that it comes to."""

INSIDE_FACTOR = 10.0
"""Factor on the cost of a lane to a closed node, so that a vehicle inside takes the shortest way out."""

_SLACK_S = 1e-9
"""Largest difference between two sums of the same lanes in another order; real lanes never differ so little."""


class Way(msgspec.Struct, frozen=True, gc=False):
    """A way from one node to another."""

    nodes: tuple[str, ...]
    """Nodes from the start to the goal, both included; a single one where they are the same."""
    length_m: float
    duration_s: float
    """Duration from standstill to standstill with a free way and every door shut (s)."""


class _Step(msgspec.Struct, frozen=True):
    """A lane as the search sees it."""

    node: str
    """Node at the end of the lane."""
    start: int
    end: int
    length_m: float
    top_mps: float
    lane_s: float
    """Its cost: its time at the lower of the lane's limit and the vehicle's top speed, and that of its door."""
    opening_s: float
    """Opening time of its door."""
    onward: list[tuple[_Step, float]]
    """The next steps, with the highest speed at the node between: straight on first, then in file order."""


class Routes:
    """Ways of one type of vehicle through a plant. Deterministic; grows its memory as it is asked.

    Args:
        roads: the plant's network.
        vehicle: the type of vehicle.
        places: place id -> node id, for `nearest`.
        restrictions: closed and slow lanes. A vehicle on a closed node may leave it over other closed ones; no way
            leads to one.
    """

    __slots__ = (
        "_entering",
        "_found",
        "_index",
        "_kept",
        "_leaving",
        "_left_s",
        "_nearest",
        "_nodes",
        "_places",
        "_rate_mps2",
        "restrictions",
    )

    def __init__(
        self,
        roads: Roads,
        vehicle: VehicleType,
        places: Mapping[str, str],
        restrictions: Restrictions = OPEN,
    ) -> None:
        self.restrictions = restrictions
        self._rate_mps2 = vehicle.acceleration_mps2
        self._places = places
        self._nodes = tuple(roads.leaving)
        self._index = {node: index for index, node in enumerate(self._nodes)}
        self._leaving = _steps(restrictions.open_lanes(roads), vehicle, self._index, restrictions.nodes)
        self._entering: list[list[tuple[int, float]]] = [[] for _ in self._index]
        for steps in self._leaving:
            for step in steps:
                self._entering[step.end].append((step.start, step.lane_s))
        self._left_s: dict[int, LaneTimes[int]] = {}
        self._found: dict[str, dict[str, Way]] = {}
        self._nearest: dict[tuple[str, tuple[str, ...]], tuple[str, Way]] = {}
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

    def leads_round(self, start_node: str, goal_node: str) -> bool:
        """Whether a way leads from one node to another on which nothing is known to lie."""
        return self.leads(start_node, goal_node)

    def leads(self, start_node: str, goal_node: str) -> bool:
        """Whether a way leads from one node to another, with or without obstacles."""
        try:
            self.way(start_node, goal_node)
        except NoWay:
            return False
        return True

    def farthest_s(self, goal_node: str) -> float:
        """Seconds from the node that is farthest from another one and can reach it; raises as `way`."""
        goal = self._index.get(goal_node)
        if goal is None:
            raise NoWay("any node", goal_node)
        left_s = {index: self._left_to(goal)(index) for index in range(len(self._nodes))}
        farthest = max((index for index in left_s if left_s[index] < inf), key=left_s.__getitem__)
        return self.duration_s(self._nodes[farthest], goal_node)

    def nearest_s(self, start_nodes: Iterable[str], goal_node: str) -> float:
        """Seconds from whichever of some nodes is nearest to another one; infinite where no way leads there from any."""
        goal, best_s = self._index.get(goal_node), inf
        if goal is None or goal_node in self.restrictions.nodes:
            return best_s
        wanted = {self._index[node] for node in start_nodes}
        # No way is shorter than its lane time, so no place beyond the best way's duration is nearer.
        for index, least_s in self._left_to(goal).nearest_first():
            if least_s > best_s or not wanted:
                break
            if index in wanted:
                wanted.discard(index)
                with suppress(NoWay):
                    best_s = min(best_s, self.duration_s(self._nodes[index], goal_node))
        return best_s

    def nearest(self, start_node: str, places: Iterable[str]) -> tuple[str, Way]:
        """The place of `places` that is reached first, and the way there.

        Args:
            start_node: where the vehicle stands.
            places: ids of machines, storages, warehouses, chargers or parking places; of equally
                near ones the first wins.

        Raises:
            NoWay: none of them can be reached.
        """
        asked = start_node, tuple(places)
        found = self._nearest.get(asked)
        if found is None:
            found = self._find_nearest(*asked)
            if len(self._nearest) >= MAX_NEAREST:
                self._nearest.clear()
            self._nearest[asked] = found
        return found

    def _find_nearest(self, start_node: str, places: tuple[str, ...]) -> tuple[str, Way]:
        """Find a nearest place that is not known yet."""
        here, best = self._index.get(start_node), None
        wanted: dict[int, tuple[int, str]] = {}
        for number, place in enumerate(places):
            wanted.setdefault(self._index[self._places[place]], (number, place))
        # No way is shorter than its lane time, so no place beyond the best way's duration is nearer.
        reached = LaneTimes(here, self._after).nearest_first() if here is not None else iter(())
        for index, least_s in reached:
            if best is not None and least_s > best[0]:
                break
            if index not in wanted:
                continue
            number, place = wanted.pop(index)
            with suppress(NoWay):
                way = self.way(start_node, self._nodes[index])
                if best is None or (way.duration_s, number) < best[:2]:
                    best = way.duration_s, number, place, way
            if not wanted:
                break
        if best is None:
            raise NoWay(start_node, "any of the places asked for")
        return best[2:]

    def way_out(self, start_node: str, stops: Container[str]) -> Way:
        """The way from a closed node to the next one where a vehicle may stand.

        Args:
            start_node: where it is.
            stops: the nodes where vehicles may stand.

        Raises:
            NoWay: it is shut in.
        """
        least_s = {start_node: 0.0}
        frontier = [(0.0, self._index[start_node])]
        while frontier:
            so_far_s, here = heappop(frontier)
            node = self._nodes[here]
            if so_far_s > least_s[node]:
                continue
            if node not in self.restrictions.nodes and node in stops:
                return self.way(start_node, node)
            for step in self._leaving[here]:
                if so_far_s + step.lane_s < least_s.get(step.node, inf):
                    least_s[step.node] = so_far_s + step.lane_s
                    heappush(frontier, (least_s[step.node], step.end))
        raise NoWay(start_node, "any node that is open")

    def _find(self, start_node: str, goal_node: str) -> Way:
        """Find a way that is not known yet, and keep it."""
        here, goal = self._index.get(start_node), self._index.get(goal_node)
        if here is None or goal is None or (goal_node in self.restrictions.nodes and here != goal):
            raise NoWay(start_node, goal_node)
        left_s = self._left_to(goal)
        if left_s(here) == inf:
            raise NoWay(start_node, goal_node)
        way = self._follow(start_node, goal_node, left_s)
        if self._kept >= MAX_WAYS:
            self._found.clear()
            self._kept = 0
        self._found.setdefault(goal_node, {})[start_node] = way
        self._kept += 1
        return way

    def _left_to(self, goal: int) -> LaneTimes[int]:
        """Least lane times to one node."""
        left_s = self._left_s.get(goal)
        if left_s is None:
            left_s = self._left_s[goal] = LaneTimes(goal, self._entering.__getitem__)
        return left_s

    def _after(self, index: int) -> Iterable[tuple[int, float]]:
        return ((step.end, step.lane_s) for step in self._leaving[index])

    def _follow(self, start_node: str, goal_node: str, left_s: LaneTimes[int]) -> Way:
        """The way along the least lane time, straight on where there is a choice."""
        here, goal = self._index[start_node], self._index[goal_node]
        nodes = [start_node]
        runs: list[Run] = []
        length_m = run_m = top_mps = doors_s = 0.0
        # The direction does not matter from standstill.
        onward: Iterable[tuple[_Step, float]] = ((step, 0.0) for step in self._leaving[here])
        while here != goal:
            left_here_s = left_s(here)
            bound_s = left_here_s + _SLACK_S
            for step, corner_mps in onward:
                left_there_s = left_s(step.end)
                # Ever nearer, or lanes shorter than the slack would lead in circles.
                if left_there_s >= left_here_s or step.lane_s + left_there_s > bound_s:
                    continue
                nodes.append(step.node)
                length_m += step.length_m
                doors_s += step.opening_s
                if corner_mps == top_mps == step.top_mps:
                    run_m += step.length_m
                else:
                    if run_m:
                        runs.append((run_m, top_mps, corner_mps))
                    run_m, top_mps = step.length_m, step.top_mps
                here, onward = step.end, step.onward
                break
            else:
                raise NoWay(start_node, goal_node)
        if run_m:
            runs.append((run_m, top_mps, 0.0))
        return Way(tuple(nodes), length_m, doors_s + runs_s(runs, self._rate_mps2))


def _steps(
    leaving: Mapping[str, tuple[DirectedLane, ...]],
    vehicle: VehicleType,
    index: Mapping[str, int],
    closed: Container[str],
) -> list[list[_Step]]:
    """The lanes that leave each node, in node order, each with its next steps."""
    steps: dict[str, list[_Step]] = {}
    for node, lanes in leaving.items():
        steps[node] = []
        for lane in lanes:
            top_mps = limit_mps(lane, vehicle)
            start, end = index[node], index[lane.end]
            cost_s = lane_time_s(lane, vehicle) * (INSIDE_FACTOR if lane.end in closed else 1.0)
            steps[node].append(
                _Step(lane.end, start, end, lane.length_m, top_mps, cost_s, lane.opening_s, [])
            )
    for node, lanes in leaving.items():
        for lane, step in zip(lanes, steps[node], strict=True):
            straight: list[tuple[_Step, float]] = []
            bent: list[tuple[_Step, float]] = []
            for ahead, after in zip(leaving[lane.end], steps[lane.end], strict=True):
                side = bent if bends(lane, ahead) else straight
                side.append((after, joint_mps(lane, ahead, vehicle)))
            step.onward.extend((*straight, *bent))
    return list(steps.values())
