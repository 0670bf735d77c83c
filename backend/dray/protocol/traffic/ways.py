"""Ways through traffic, and refuges for vehicles that make room: A* over lanes, with prices for known traffic.

On an empty floor a way costs its lane time. By convention rows and columns of lanes have alternating directions. The other
direction costs more, so that vehicles seldom meet. Announced oncoming vehicles, standing, docked or silent ones, and the vehicle's own
recent waits add to the price. None of this is a rule: every lane may be driven.
"""

from __future__ import annotations

from collections.abc import Callable, Container, Iterable, Mapping
from heapq import heappop, heappush
from itertools import count
from math import cos, inf, sin

from dray.plant import Plant, bends
from dray.plant.floor.motion import lane_s
from dray.plant.lane_times import LaneTimes
from dray.plant.model import VehicleType
from dray.protocol.traffic.places import Places
from dray.protocol.traffic.prices import OBSTRUCTED_S, STANDS_S, Prices

AGAINST = 1.5
"""Factor of the lane time against the convention."""

ONCOMING = 3.0
"""Factor of the lane time that is added for every announced oncoming vehicle."""

THROUGH_DOCK_S = 30.0
"""Price of a way through a dock that is not its goal."""

ROW_M = 1.0
"""Largest gap between neighbouring lanes of one row or column."""

STRAIGHT = 0.05
"""Largest sine of the angle to an axis at which a lane belongs to a row or column."""

REFUGE_THROUGH_S = 8.0
"""Price of a place whose holder has to make room in turn, on the way to a refuge."""

OWN_WAY = 0.5
"""Factor of the lane time for lanes to a refuge that lead along the vehicle's own way."""


class _Road:
    """A lane, as A* uses it."""

    __slots__ = ("against", "end", "lane_s", "needs", "onward", "start")

    def __init__(self, start: str, end: str, lane_s: float, needs: tuple[str, ...], *, against: bool) -> None:
        self.start, self.end, self.lane_s, self.needs, self.against = start, end, lane_s, needs, against
        self.onward: list[tuple[_Road, float]] = []
        """The lanes that may follow, and the time (s) that the bend costs."""


class Ways:
    """Ways and refuges of one type of vehicle.

    Args:
        plant: the roads.
        places: the places that lanes need.
        vehicle: its speeds and acceleration.
        convention: whether the convention of directions counts.
    """

    def __init__(
        self, plant: Plant, places: Places, vehicle: VehicleType, *, convention: bool = True
    ) -> None:
        self._places = places
        against = _against(plant) if convention else frozenset()
        own = plant.roads_of(vehicle.id)
        roads = {
            (lane.start, lane.end): _Road(
                lane.start,
                lane.end,
                lane_s(lane, vehicle),
                places.needs(lane.start, lane.end),
                against=(lane.start, lane.end) in against,
            )
            for lane in own.lanes
        }
        slows_s = (vehicle.max_speed_mps - vehicle.turn_speed_mps) ** 2 / (
            vehicle.acceleration_mps2 * vehicle.max_speed_mps
        )
        self._leaving: dict[str, list[_Road]] = {}
        self._entering: dict[str, list[_Road]] = {node: [] for node in own.leaving}
        for node, lanes in own.leaving.items():
            self._leaving[node] = [roads[lane.start, lane.end] for lane in lanes]
            for lane in lanes:
                road = roads[lane.start, lane.end]
                self._entering[lane.end].append(road)
                road.onward = [
                    (roads[after.start, after.end], slows_s if bends(lane, after) else 0.0)
                    for after in own.leaving[lane.end]
                ]
        self._left_s: dict[str, LaneTimes[str]] = {}

    def way(self, start: str, goal: str, prices: Prices | None = None) -> tuple[str, ...] | None:
        """The cheapest way from one node to another, both included; None when no lanes lead there."""
        left_s = self._left_s.get(goal)
        if left_s is None:
            left_s = self._left_s[goal] = LaneTimes(goal, self._before)
        if start == goal:
            return (start,)
        if left_s(start) == inf:
            return None

        def cost_s(road: _Road) -> float:
            price_s = road.lane_s
            if prices is not None and prices.admits is not None and not prices.admits(road.start, road.end):
                return inf
            if road.against:
                price_s *= AGAINST
            if prices is not None:
                if (road.start, road.end) in prices.obstructed:
                    price_s += OBSTRUCTED_S
                oncoming = prices.oncoming(road.start, road.end)
                if oncoming:
                    price_s += ONCOMING * road.lane_s * oncoming
                for place in road.needs:
                    price_s += prices.place_s.get(place, 0.0)
            if road.end != goal and road.end in self._places.docks and road.end in self._places.dock_entries:
                price_s += THROUGH_DOCK_S
            return price_s

        return self._search(start, left_s, cost_s, lambda node: node == goal)

    def refuge(
        self,
        start: str,
        *,
        avoid: Container[str],
        forbidden: Container[str],
        taken: Container[str],
        prices: Prices,
        own: Iterable[str] = (),
        behind_others: bool = True,
    ) -> tuple[str, ...] | None:
        """The cheapest way to a refuge; None when there is none.

        Args:
            start: where the vehicle stands.
            avoid: nodes where it would be in the way again; it may drive over them.
            forbidden: places it cannot get: those of vehicles for which it makes room, and of docked, silent and more urgent ones.
            taken: places whose holders would have to make room in turn: no refuge, but it may pass them.
            prices: of places.
            own: the nodes of its own way.
            behind_others: whether the refuge may lie behind a vehicle that has to let this one past. Otherwise the way ends where
                that vehicle is, which makes room by driving on.
        """
        mine = frozenset(own)

        def cost_s(road: _Road) -> float:
            if prices.admits is not None and not prices.admits(road.start, road.end):
                return inf
            if (road.start, road.end) in prices.obstructed:
                return inf
            price_s = road.lane_s * (OWN_WAY if road.end in mine else 1.0)
            for place in road.needs:
                if place in forbidden:
                    return inf
                if place in taken:
                    price_s += REFUGE_THROUGH_S
                price_s += min(prices.place_s.get(place, 0.0), STANDS_S)
            return price_s

        def is_refuge(node: str) -> bool:
            place = self._places.place_of(node)
            return (
                node != start
                and node not in avoid
                and place not in taken
                and place not in forbidden
                and self._places.may_stop(node)
            )

        def can_be_left(node: str) -> bool:
            """Whether the vehicle there can make room by driving on where this way leads."""
            return node not in avoid and self._places.place_of(node) in taken and self._places.may_stop(node)

        way = self._search(start, lambda _: 0.0, cost_s, is_refuge)
        if way is None or behind_others:
            return way
        end = next((number for number in range(1, len(way)) if can_be_left(way[number])), len(way) - 1)
        return way[: end + 1]

    def _search(
        self,
        start: str,
        left_s: Callable[[str], float],
        cost_s: Callable[[_Road], float],
        is_goal: Callable[[str], bool],
    ) -> tuple[str, ...] | None:
        """A* over lanes instead of nodes, so that bends count."""
        numbers = count()
        open_roads: list[tuple[float, int, float, _Road, _Road | None]] = []
        came_from: dict[_Road, _Road | None] = {}
        for road in self._leaving[start]:
            price_s = cost_s(road)
            if price_s < inf:
                heappush(open_roads, (price_s + left_s(road.end), next(numbers), price_s, road, None))
        while open_roads:
            _, _, so_far_s, road, before = heappop(open_roads)
            if road in came_from:
                continue
            came_from[road] = before
            if is_goal(road.end):
                return _way_back(road, came_from)
            for after, bend_s in road.onward:
                if after in came_from or after.end == road.start:
                    continue
                price_s = cost_s(after)
                if price_s < inf:
                    through_s = so_far_s + bend_s + price_s
                    heappush(
                        open_roads, (through_s + left_s(after.end), next(numbers), through_s, after, road)
                    )
        return None

    def _before(self, node: str) -> Iterable[tuple[str, float]]:
        return ((road.start, road.lane_s) for road in self._entering[node])


def _way_back(road: _Road | None, came_from: Mapping[_Road, _Road | None]) -> tuple[str, ...]:
    """The nodes along the lanes that led to `road`, its end included."""
    nodes: list[str] = []
    while road is not None:
        nodes.append(road.end)
        start, road = road.start, came_from[road]
    nodes.append(start)
    return tuple(reversed(nodes))


def _against(plant: Plant) -> frozenset[tuple[str, str]]:
    """The lanes against the convention of alternating rows and columns, derived from the plant file alone."""
    nodes = plant.nodes
    docks = {plant.node_of(place) for place in plant.places}
    along_x, along_y = [], []
    for lane in plant.roads.lanes:
        if plant.roads.lane(lane.end, lane.start) is None or docks & {lane.start, lane.end}:
            continue
        if abs(sin(lane.heading_rad)) < STRAIGHT:
            along_x.append(lane)
        elif abs(cos(lane.heading_rad)) < STRAIGHT:
            along_y.append(lane)
    row_of = _rows(nodes[lane.start].y_m for lane in along_x)
    column_of = _rows(nodes[lane.start].x_m for lane in along_y)
    against = []
    for lane in along_x:
        eastward = cos(lane.heading_rad) > 0.0
        if eastward == bool(row_of[nodes[lane.start].y_m] % 2):
            against.append((lane.start, lane.end))
    for lane in along_y:
        northward = sin(lane.heading_rad) > 0.0
        if northward != bool(column_of[nodes[lane.start].x_m] % 2):
            against.append((lane.start, lane.end))
    return frozenset(against)


def _rows(positions_m: Iterable[float]) -> dict[float, int]:
    """Number the rows: positions with gaps up to `ROW_M` are one row."""
    numbers: dict[float, int] = {}
    row, last_m = -1, -inf
    for position_m in sorted(set(positions_m)):
        if position_m - last_m > ROW_M:
            row += 1
        numbers[position_m] = row
        last_m = position_m
    return numbers
