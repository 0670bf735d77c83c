"""A planner that knows everything: windowed prioritised planning in continuous time, as RHCR, with SIPP on places.

It exists for the benchmark only. Every few seconds it plans all vehicles anew, one after another, around the
reservations of earlier ones within a window. A vehicle without a plan goes first in the next try. Plans are executed
by their order: a vehicle takes a place when all earlier vehicles are through, so delays do no harm (Hoenig et al.).
Its network is perfect, and its clock too.
"""

from __future__ import annotations

from collections import defaultdict, deque
from collections.abc import Callable, Iterator, Mapping
from heapq import heappop, heappush
from itertools import count, pairwise
from math import inf

from dray.plant import DirectedLane, Plant, bends
from dray.plant.restrictions import OPEN
from dray.protocol.traffic.driving.reserved_way import ReservedWay
from dray.protocol.traffic.driving.wheels import Wheels
from dray.protocol.traffic.places import Places
from dray_sim.bench.traffic.carrier import Carrier
from dray_sim.bench.traffic.clock import LeanClock
from dray_sim.bench.traffic.jobs import HANDLING_S
from dray_sim.bench.traffic.visits import Hops, Step, Visit, first_free_s, free_spans

WINDOW_S = 20.0
"""Horizon within which plans avoid one another."""

REPLAN_S = 2.5
TICK_S = 0.25
TRIES = 10
EVADE_S = 4.0
"""Additional time to get out of the way, with every other try."""

COMMITTED = 3
"""Nodes ahead that are granted at most, and not planned any more."""

START_S = 1.25
"""Time lost by setting off from standstill."""

BEND_S = 1.1
CLEAR_S = 1.8
"""Time from setting off until a vehicle is clear of its place."""

LEAVE_S = 4.0
"""Time from the end of handling until a dock counts as left."""


class CentralPilot:
    """Drives the hops that the planner grants."""

    def __init__(self, carrier: Carrier, planner: Planner) -> None:
        self.carrier = carrier
        self.way = ReservedWay(planner.places, carrier.travel.node)
        self.goal = carrier.travel.node
        self.since_s = 0.0
        self.docked_until_s = 0.0
        self.planned: deque[Visit] = deque()
        """One visit for each hop of the way after the base."""
        self.taken: list[Visit] = []
        """Visits of the places that it holds."""
        self._planner = planner
        self._asked = True
        kind = carrier.kind
        self._wheels = Wheels(
            kind.max_speed_mps, kind.acceleration_mps2, count(1).__next__, restrictions=lambda: OPEN
        )

    def go(self, node: str, *, idle: bool) -> None:
        self.goal, self.since_s = node, self._planner.clock.now_s + (1e6 if idle else 0.0)
        self._asked = False
        self.docked_until_s = 0.0
        self._arrive()
        if not self._asked:
            self._planner.plan_soon()

    def dock(self) -> None:
        self.docked_until_s = self._planner.clock.now_s + HANDLING_S

    def rest(self) -> None:
        """Do nothing: the planner may send it away."""

    def passed(self, node: str) -> None:
        self.way.pass_next()
        self.sense()
        self._arrive()
        self._planner.extend(self)

    def sense(self) -> None:
        """Give back the places that it is clear of."""
        if not self.way.stands:
            self.way.move(self.carrier.sense()[0])
        before = set(self.way.held)
        if self.way.give_back():
            gone = before - set(self.way.held)
            for visit in self.taken:
                visit.done = visit.done or visit.place in gone
            self.taken = [visit for visit in self.taken if not visit.done]

    def _arrive(self) -> None:
        if not self._asked and self.way.stands and self.way.node == self.goal:
            self._asked = True
            self.carrier.arrive()

    def drive_on(self) -> None:
        """The base has grown."""
        self.carrier.instruct(self._wheels.drive(self.way, self.carrier.sense()[1]))


class Planner:
    """Plans all vehicles.

    Args:
        plant: the roads.
        places: that lanes need.
        clock: of the world.

    Attributes:
        pilots: all vehicles, by name.
    """

    def __init__(self, plant: Plant, places: Places, clock: LeanClock) -> None:
        self.places = places
        self.clock = clock
        self.pilots: dict[str, CentralPilot] = {}
        self._plant = plant
        self._hops = Hops(plant, places)
        self._left_s: dict[str, dict[str, float]] = {}
        self._reserved: dict[str, list[Visit]] = {}
        self._planned_s = -inf

    def start(self) -> None:
        self.clock.call_at(self.clock.now_s, self._tick)

    def plan_soon(self) -> None:
        """A vehicle has another goal."""
        self._planned_s = min(self._planned_s, self.clock.now_s - REPLAN_S + TICK_S)

    def _tick(self) -> None:
        for pilot in self.pilots.values():
            pilot.sense()
        if self.clock.now_s - self._planned_s >= REPLAN_S:
            self._planned_s = self.clock.now_s
            self._plan()
        for pilot in self.pilots.values():
            self.extend(pilot)
        self.clock.call_at(self.clock.now_s + TICK_S, self._tick)

    # --- carrying out ----------------------------------------------------------------------------

    def extend(self, pilot: CentralPilot) -> None:
        """Grant the next hops, as long as it is this vehicle's turn."""
        grew = False
        while len(pilot.way.base) < COMMITTED:
            if not pilot.planned or not self._has_turn(pilot, pilot.planned[0]):
                break
            visit = pilot.planned.popleft()
            for _ in visit.nodes:
                pilot.way.take_next()
            pilot.taken += visit.group
            grew = True
        if grew:
            pilot.drive_on()

    def _has_turn(self, pilot: CentralPilot, mine: Visit) -> bool:
        places = {visit.place for visit in mine.group}
        if any(not places.isdisjoint(other.way.held) for other in self.pilots.values() if other is not pilot):
            return False
        return all(
            visit.done or visit.atv == mine.atv or visit.from_s >= mine.from_s
            for place in places
            for visit in self._reserved.get(place, ())
        )

    # --- planning --------------------------------------------------------------------------------

    def _plan(self) -> None:
        """Plan all vehicles, the longest on their way first; one without a plan goes first in the next try."""
        order = sorted(self.pilots, key=lambda atv: (self.pilots[atv].since_s, atv))
        least = len(order) + 1
        ways: dict[str, list[Visit]] = {}
        for attempt in range(TRIES):
            reserved, starts = self._commitments(EVADE_S * (attempt // 2))
            tried: dict[str, list[Visit]] = {}
            failed: list[str] = []
            for atv in order:
                way = self._search(atv, starts[atv], reserved)
                if way is None:
                    failed.append(atv)
                else:
                    tried[atv] = way
            if len(failed) < least:
                least, self._reserved, ways = len(failed), reserved, tried
            if not failed:
                break
            order = [*failed, *(atv for atv in order if atv not in failed)]
        for atv, pilot in self.pilots.items():
            planned = ways.get(atv, [])
            coming = [visit for hop in planned for visit in hop.group]
            pilot.taken = [
                visit
                for place in pilot.way.held
                for visit in self._reserved[place]
                if visit.atv == atv and visit not in coming
            ]
            pilot.planned = deque(planned)
            pilot.way.turn_to((pilot.way.base_end, *(node for visit in planned for node in visit.nodes)))

    def _commitments(self, evade_s: float) -> tuple[dict[str, list[Visit]], dict[str, float]]:
        """Places already held, each with its end, and when each vehicle will be at the end of its base.

        Vehicles that come first in the order leave the others `evade_s` to get out of their way.
        """
        now_s = self.clock.now_s
        reserved: dict[str, list[Visit]] = defaultdict(list)
        starts: dict[str, float] = {}
        for atv, pilot in self.pilots.items():
            driven = pilot.way
            at_s = now_s
            behind = set(driven.held) - set(driven.base) - {driven.node}
            nodes = (driven.node, *driven.base)
            past_m, speed_mps = pilot.carrier.sense()
            for index, (here, there) in enumerate(pairwise(nodes)):
                lane_s = self._lane_s(here, there, pilot)
                if index == 0:
                    lane_s *= max(1.0 - past_m / self.places.length_m(here, there), 0.0)
                    lane_s += START_S if speed_mps < 0.3 else 0.0
                if here in driven.held:
                    reserved[here].append(Visit(here, atv, now_s - 1.0, at_s + CLEAR_S))
                at_s += lane_s
                for place in self.places.needs(here, there):
                    if place != there and place in driven.held:
                        behind.discard(place)
                        reserved[place].append(Visit(place, atv, now_s - 1.0, at_s))
            if pilot.docked_until_s > now_s:
                at_s = pilot.docked_until_s
            starts[atv] = at_s
            if driven.base_end in reserved and any(visit.atv == atv for visit in reserved[driven.base_end]):
                reserved[driven.base_end] = [visit for visit in reserved[driven.base_end] if visit.atv != atv]
            reserved[driven.base_end].append(Visit(driven.base_end, atv, now_s - 1.0, at_s + evade_s))
            for place in behind:
                reserved[place].append(Visit(place, atv, now_s - 1.0, now_s + CLEAR_S))
        return reserved, starts

    def _search(self, atv: str, start_s: float, reserved: dict[str, list[Visit]]) -> list[Visit] | None:
        """Search a way from the end of a vehicle's base with SIPP, and reserve it.

        Returns None when the vehicle can neither go nor stay.
        """
        pilot = self.pilots[atv]
        start = pilot.way.base_end
        end_s = self.clock.now_s + WINDOW_S
        docked = pilot.docked_until_s > self.clock.now_s
        goal = start if docked else pilot.goal
        left_s = self._left_to(goal)
        numbers = count()
        free: dict[str, list[tuple[float, float]]] = {}

        def intervals(place: str) -> list[tuple[float, float]]:
            if place not in free:
                free[place] = free_spans(
                    [visit for visit in reserved.get(place, ()) if visit.atv != atv and visit.from_s < end_s]
                )
            return free[place]

        first = next((span for span in intervals(start) if span[0] <= start_s < span[1]), None)
        if first is None:
            first = (start_s, start_s + CLEAR_S + 0.1)
        # Cost, number, arrival, node, free until, how it came there.
        states: list[tuple[float, int, float, str, float, Step | None]] = [
            (start_s + left_s.get(start, inf), next(numbers), start_s, start, first[1], None)
        ]
        closed: set[tuple[str, float]] = set()
        while states:
            _, _, at_s, node, until_s, step = heappop(states)
            if node == "":
                return self._reserve(atv, start, start_s, step, end_s, reserved)
            if (node, until_s) in closed:
                continue
            closed.add((node, until_s))
            stays_s = at_s + HANDLING_S + LEAVE_S if not docked else inf
            arrives = node == goal and until_s >= min(stays_s, end_s)
            if arrives or at_s >= end_s:
                last_s = max(end_s, stays_s) if arrives else at_s + CLEAR_S
                return self._reserve(atv, start, start_s, step, last_s, reserved)
            if until_s >= end_s:
                # It may wait here until the window ends.
                heappush(states, (end_s + left_s.get(node, inf), next(numbers), end_s, "", inf, step))
            if docked:
                continue
            for onward in self._onward(pilot, node, at_s, until_s, step, intervals):
                if (onward.end, onward.until_s) not in closed and onward.end in left_s:
                    cost_s = onward.arrive_s + left_s[onward.end]
                    heappush(
                        states, (cost_s, next(numbers), onward.arrive_s, onward.end, onward.until_s, onward)
                    )
        return None

    def _onward(
        self,
        pilot: CentralPilot,
        node: str,
        at_s: float,
        until_s: float,
        step: Step | None,
        intervals: Callable[[str], list[tuple[float, float]]],
    ) -> Iterator[Step]:
        """The possible next hops, each at the first moment of every interval in which its end is free."""
        before = None if step is None else self._plant.roads.lane((step.start, *step.nodes)[-2], node)
        for nodes in self._hops.leaving(node):
            hop_s = 0.0
            entered, here = before, node
            for there in nodes:
                lane = self._lane(here, there)
                hop_s += self._lane_s(here, there, pilot)
                hop_s += BEND_S if entered is not None and bends(entered, lane) else 0.0
                entered, here = lane, there
            crossed = [intervals(place) for place in self._hops.crossed(node, nodes)]
            for from_s, to_s in intervals(nodes[-1]):
                leave_s = self._free_of(crossed, max(at_s, from_s), hop_s + START_S)
                waits = leave_s > at_s or step is None
                arrive_s = leave_s + hop_s + (START_S if waits else 0.0)
                if leave_s + CLEAR_S <= until_s and arrive_s + CLEAR_S <= to_s:
                    yield Step(node, nodes, leave_s, arrive_s, to_s, step)

    @staticmethod
    def _free_of(crossed: list[list[tuple[float, float]]], from_s: float, lasts_s: float) -> float:
        """The first moment from which all crossings of a hop are free for so long."""
        while True:
            first_s = max((first_free_s(spans, from_s, lasts_s) for spans in crossed), default=from_s)
            if first_s in (from_s, inf):
                return first_s
            from_s = first_s

    def _reserve(
        self,
        atv: str,
        start: str,
        start_s: float,
        step: Step | None,
        until_s: float,
        reserved: dict[str, list[Visit]],
    ) -> list[Visit]:
        steps: list[Step] = []
        while step is not None:
            steps.append(step)
            step = step.before
        steps.reverse()
        leaves_s = [one.leave_s for one in steps[1:]]
        visits: list[Visit] = []
        for one, next_s in zip(steps, [*leaves_s, None][: len(steps)], strict=True):
            last_s = until_s if next_s is None else next_s + CLEAR_S
            crossed = [
                Visit(place, atv, one.leave_s, one.arrive_s)
                for place in self._hops.crossed(one.start, one.nodes)
            ]
            visits.append(Visit(one.end, atv, one.leave_s, last_s, nodes=one.nodes, crossed=crossed))
            for visit in visits[-1].group:
                reserved[visit.place].append(visit)
        stays_s = steps[0].leave_s + CLEAR_S if steps else until_s
        for visit in reserved[start]:
            if visit.atv == atv and visit not in visits:
                visit.until_s = max(stays_s, start_s)
        return visits

    def _lane(self, start: str, end: str) -> DirectedLane:
        lane = self._plant.roads.lane(start, end)
        if lane is None:
            raise KeyError((start, end))
        return lane

    def _lane_s(self, start: str, end: str, pilot: CentralPilot) -> float:
        lane = self._lane(start, end)
        return lane.length_m / min(lane.speed_limit_mps, pilot.carrier.kind.max_speed_mps)

    def _left_to(self, goal: str) -> Mapping[str, float]:
        left_s = self._left_s.get(goal)
        if left_s is None:
            left_s = {}
            nodes = [(0.0, goal)]
            while nodes:
                so_far_s, node = heappop(nodes)
                if node in left_s:
                    continue
                left_s[node] = so_far_s
                for lane in self._plant.roads.entering[node]:
                    if lane.start not in left_s:
                        heappush(
                            nodes, (so_far_s + lane.length_m / min(lane.speed_limit_mps, 1.5), lane.start)
                        )
            self._left_s[goal] = left_s
        return left_s
