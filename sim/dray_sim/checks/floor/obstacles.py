"""Invariants 20 and 21: no body touches an obstacle or a door, and vehicles report obstacles and forget them in time.

Bodies are judged by geometry alone, when their motion changes and at every message. A vehicle's known obstacles are
examined at each heartbeat. It must have reported those that it met itself, as long as it has WLAN, and must forget
each in time.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import hypot

from dray.messages import AtvHeartbeat, Link, Message, ObstacleSeen
from dray.plant.floor.rectangles import Rectangle, gap_m
from dray.plant.restrictions import Ends
from dray.protocol.closures.obstacles import lane_of
from dray.protocol.vehicle.atv import Atv
from dray_sim.bodies.vehicle.course import Course
from dray_sim.checks.broken import InvariantBroken
from dray_sim.checks.floor.overlaps import TOUCH_M
from dray_sim.factory.sim_factory import SimFactory

INSIDE, TOLD = 20, 21

LATE_S = 5.0
"""Tolerance: a process that was away forgets old obstacles with its next step."""


class MindsObstacles:
    """Watches all vehicles of a factory.

    Args:
        factory: whose vehicles are watched; one that is added later from the next message on.

    Attributes:
        met: how many obstacles vehicles have told of.
    """

    def __init__(self, factory: SimFactory) -> None:
        self.met = 0
        self._factory = factory
        self._told: set[tuple[str, Ends]] = set()
        """Pairs of a vehicle and a lane that it has reported."""
        self._courses: dict[str, Course] = {}
        self._doors: dict[str, dict[Ends, Rectangle]] = {}
        """Per vehicle, the leaves that it may touch on its course, shut or not: looked up once, as leaves stay where
        they are."""
        self._lie: dict[Ends, Rectangle] = {}
        """What lay on the lanes when `_near` was looked up."""
        self._near: dict[str, dict[Ends, Rectangle]] = {}
        """Per vehicle, what it may touch of that on its course."""
        self._watched: dict[str, None] = {}
        self._broken: InvariantBroken | None = None
        self._watch_new()

    def on_message(self, at_s: float, sender: str, _address: str, message: Message) -> None:
        """See `Listener`.

        Raises:
            InvariantBroken: a body is inside an obstacle, or a vehicle keeps one for itself, or for ever.
        """
        self._watch_new()
        if type(message) is ObstacleSeen and message.there:
            self.met += 1
            self._told.add((sender, lane_of(message.start, message.end)))
        self._look_round()
        for vehicle, course in self._courses.items():
            self._judge(vehicle, course, at_s)
        if self._broken is not None:
            raise self._broken
        if type(message) is AtvHeartbeat:
            self._look_at(message, at_s)

    def check_end(self, at_s: float) -> None:
        """See `on_message`."""
        self._look_round()
        for vehicle, course in self._courses.items():
            self._judge(vehicle, course, at_s)
        if self._broken is not None:
            raise self._broken

    def _look_at(self, beat: AtvHeartbeat, at_s: float) -> None:
        agent = self._factory.workers[beat.atv].agent if beat.atv in self._factory.vehicles else None
        if not isinstance(agent, Atv) or agent.incarnation != beat.incarnation:
            return
        now_s = self._factory.clock_of(beat.atv).now_s()
        for lane, known in agent.floor.obstacles.known.items():
            if known.until_s < now_s - LATE_S:
                raise InvariantBroken(TOLD, at_s, f"{beat.atv} has not forgotten what lay on {lane}")
            if known.by == beat.atv and agent.link is Link.WLAN and (beat.atv, lane) not in self._told:
                raise InvariantBroken(TOLD, at_s, f"{beat.atv} has told nobody what lies on {lane}")

    def _watch_new(self) -> None:
        if len(self._watched) == len(self._factory.vehicles):
            return
        for name, vehicle in self._factory.vehicles.items():
            if name not in self._watched:
                self._watched[name] = None
                vehicle.watch_course(self._on_course)

    def _look_round(self) -> None:
        """Look up what each vehicle may touch, if that has changed."""
        shapes = self._factory.floor.obstacles.shapes
        if shapes != self._lie:
            self._lie = dict(shapes)
            for vehicle, course in self._courses.items():
                self._near[vehicle] = _touchable(course, shapes)

    def _on_course(self, vehicle: str, course: Course) -> None:
        self._look_round()
        before = self._courses.pop(vehicle, None)
        if before is not None:
            self._judge(vehicle, before, course.begin_s)
        if not course.lifted:
            self._doors[vehicle] = _touchable(course, self._factory.floor.doors.leaves)
            self._near[vehicle] = _touchable(course, self._lie)
            self._judge(vehicle, course, course.begin_s)
            self._courses[vehicle] = course

    def _judge(self, vehicle: str, course: Course, at_s: float) -> None:
        doors, shapes = self._doors[vehicle], self._near[vehicle]
        if not (shapes or doors) or self._broken is not None:
            return
        is_shut = self._factory.floor.doors.is_shut
        leaves = {lane: leaf for lane, leaf in doors.items() if is_shut(lane)}
        covers = course.covers(at_s)
        for what, there in (("what lies", shapes), ("the shut door", leaves)):
            for lane, shape in there.items():
                if gap_m(covers, shape) < -TOUCH_M:
                    seen = f"{vehicle} drives into {what} between {lane[0]} and {lane[1]}"
                    self._broken = InvariantBroken(INSIDE, at_s, seen)


def _touchable(course: Course, shapes: Mapping[Ends, Rectangle]) -> dict[Ends, Rectangle]:
    """Those shapes that a body may touch on its course."""
    return {lane: shape for lane, shape in shapes.items() if _may_touch(course, shape)}


def _may_touch(course: Course, shape: Rectangle) -> bool:
    """Whether a body comes so near to a shape on its course that the circles around them meet."""
    end_x_m, end_y_m = course.end
    apart_m = hypot(shape.x_m - (course.x_m + end_x_m) / 2.0, shape.y_m - (course.y_m + end_y_m) / 2.0)
    return apart_m <= course.reach_m / 2.0 + course.radius_m + shape.radius_m
