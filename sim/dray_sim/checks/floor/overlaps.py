"""Invariant 13: no two vehicles are in one spot. Geometry alone decides, not the protocol's assumptions.

Every vehicle is a rectangle as long and wide as its type. Its motion is known in closed form until something changes
(`Course`), so the time between two changes is judged afterwards, and as a whole. From any moment, two vehicles need
at least the time to close their gap at their highest speeds. Then they are examined again (conservative advancement).
An overlap that is deeper than `MISSED_M` is found, however short it is. A vehicle that sets off in another direction
has turned on the spot. The area that it sweeps is judged in the same way, by the angle.

A lifted vehicle is in no one's way until it is put down. Vehicles without a body are nowhere.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from math import floor, pi

from dray.messages import Message
from dray.plant.floor.rectangles import Rectangle, gap_m
from dray_sim.bodies.vehicle.course import Course
from dray_sim.bodies.vehicle.vehicle import SimVehicle
from dray_sim.checks.broken import InvariantBroken

NUMBER = 13

TOUCH_M = 1e-9
"""Rounding error of a sine and a cosine. There is no other tolerance: right of way holds an area that is larger than
the driven one by at least `dray.plant.floor.clearance.CLEARANCE_M`."""

MISSED_M = 1e-4
"""No deeper overlap is missed: two vehicles that approach one another are examined again at least after this
distance."""

CELL_M = 3.0
"""Vehicles are looked for in the cells that they can come into."""

Cell = tuple[int, int]


@dataclass(frozen=True, slots=True)
class Overlap:
    """Two vehicles in one spot."""

    at_s: float
    first: str
    second: str
    x_m: float
    y_m: float
    depth_m: float

    def __str__(self) -> str:
        return f"{self.first} and {self.second} are in one spot at ({self.x_m:.2f}, {self.y_m:.2f}), {self.depth_m:.3f} m deep"


class Overlaps:
    """Watches all bodies of a floor.

    Args:
        vehicles: by id; one that is added later is watched from the next message on.
        strict: whether an overlap breaks the run; else they are only counted.
        told: is told each of them.

    Attributes:
        first: the first overlap that was found; None for none.
        count: how many times two vehicles came into one spot.
    """

    def __init__(
        self,
        vehicles: Mapping[str, SimVehicle],
        *,
        strict: bool = True,
        told: Callable[[Overlap], None] = lambda _: None,
    ) -> None:
        self.first: Overlap | None = None
        self.count = 0
        self._vehicles = vehicles
        self._strict = strict
        self._told = told
        self._watched: dict[str, None] = {}
        self._courses: dict[str, Course] = {}
        """Courses of the vehicles on the floor."""
        self._cells: dict[str, tuple[Cell, ...]] = {}
        self._in_cell: dict[Cell, dict[str, None]] = {}
        self._touching: set[tuple[str, str]] = set()
        """Pairs that were in one spot when they were looked at last."""
        self._watch_new()

    def on_message(self, at_s: float, _sender: str, _address: str, _message: Message) -> None:
        """See `Listener`.

        Raises:
            InvariantBroken: two vehicles were in one spot since the last message.
        """
        self._watch_new()
        if self._strict and self.first is not None:
            raise InvariantBroken(NUMBER, self.first.at_s, str(self.first))

    def check_end(self, at_s: float) -> None:
        """Judge the courses that have not changed, up to now.

        Raises:
            InvariantBroken: see `on_message`.
        """
        self._watch_new()
        judged: set[str] = set()
        for vehicle, course in self._courses.items():
            self._judge(vehicle, course, at_s, judged)
            judged.add(vehicle)
        if self._strict and self.first is not None:
            raise InvariantBroken(NUMBER, self.first.at_s, str(self.first))

    def _watch_new(self) -> None:
        if len(self._watched) == len(self._vehicles):
            return
        for name, vehicle in self._vehicles.items():
            if name not in self._watched:
                self._watched[name] = None
                vehicle.watch_course(self._on_course)

    def _on_course(self, vehicle: str, course: Course) -> None:
        """Note a vehicle's new course: its course until now is over, and can be judged."""
        before = self._courses.get(vehicle)
        if before is not None:
            self._judge(vehicle, before, course.begin_s)
        if course.lifted:
            self._lift(vehicle)
            return
        if before is not None and course.heading_rad != before.heading_rad:
            self._judge_turn(vehicle, before, course)
        self._courses[vehicle] = course
        self._enter(vehicle, course)

    def _lift(self, vehicle: str) -> None:
        """Forget a vehicle that is off the floor."""
        if self._courses.pop(vehicle, None) is None:
            return
        for cell in self._cells.pop(vehicle):
            del self._in_cell[cell][vehicle]
        self._touching = {pair for pair in self._touching if vehicle not in pair}

    # --- who is near ------------------------------------------------------------------------------

    def _enter(self, vehicle: str, course: Course) -> None:
        """Be in the cells that the vehicle can come into."""
        (left, low), (right, high) = _cells_of(course)
        cells = tuple((x, y) for x in range(left, right + 1) for y in range(low, high + 1))
        before = self._cells.get(vehicle, ())
        if cells == before:
            return
        for cell in before:
            del self._in_cell[cell][vehicle]
        for cell in cells:
            self._in_cell.setdefault(cell, {})[vehicle] = None
        self._cells[vehicle] = cells

    def _near(self, vehicle: str) -> dict[str, None]:
        near: dict[str, None] = {}
        for cell in self._cells[vehicle]:
            near.update(self._in_cell[cell])
        near.pop(vehicle, None)
        return near

    # --- judging ------------------------------------------------------------------------------------

    def _judge(
        self, vehicle: str, course: Course, until_s: float, judged: Collection[str] = frozenset()
    ) -> None:
        """Judge a vehicle against all near ones since either changed its motion, except those that are judged already."""
        near = self._near(vehicle)
        for pair in [pair for pair in self._touching if vehicle in pair and not near.keys() & set(pair)]:
            self._touching.discard(pair)
        for other in near:
            if other in judged:
                continue
            against = self._courses[other]
            begin_s = max(course.begin_s, against.begin_s)
            if begin_s <= until_s:
                self._advance(vehicle, course, other, against, begin_s, until_s)

    def _advance(
        self, vehicle: str, course: Course, other: str, against: Course, at_s: float, until_s: float
    ) -> None:
        """Go from one moment to the next at which the two could touch."""
        pair = (vehicle, other) if vehicle < other else (other, vehicle)
        nearing_mps = course.nearing_mps(against)
        if course.apart_m(against, at_s) > nearing_mps * (until_s - at_s):
            self._touching.discard(pair)
            return
        while True:
            covers = course.covers(at_s)
            gap = gap_m(covers, against.covers(at_s))
            if gap < -TOUCH_M:
                self._note(pair, covers, at_s, -gap)
                return
            if gap > 0.0:
                self._touching.discard(pair)
            if at_s >= until_s or not nearing_mps:
                return
            at_s = min(until_s, at_s + max(gap + TOUCH_M, MISSED_M) / nearing_mps)

    def _judge_turn(self, vehicle: str, before: Course, course: Course) -> None:
        """Judge the area that a vehicle sweeps when it turns on the spot, the shorter way round."""
        at_s = course.begin_s
        turn = (course.heading_rad - before.heading_rad + pi) % (2.0 * pi) - pi
        sign = 1.0 if turn >= 0.0 else -1.0
        for other in self._near(vehicle):
            against = self._courses[other].covers(at_s)
            pair = (vehicle, other) if vehicle < other else (other, vehicle)
            turned = 0.0
            while True:
                heading_rad = before.heading_rad + sign * turned
                covers = Rectangle(course.x_m, course.y_m, heading_rad, course.length_m, course.width_m)
                gap = gap_m(covers, against)
                if gap < -TOUCH_M:
                    self._note(pair, covers, at_s, -gap)
                    break
                if turned >= abs(turn):
                    break
                turned = min(abs(turn), turned + max(gap + TOUCH_M, MISSED_M) / covers.radius_m)

    def _note(self, pair: tuple[str, str], covers: Rectangle, at_s: float, depth_m: float) -> None:
        if pair in self._touching:
            return
        self._touching.add(pair)
        self.count += 1
        overlap = Overlap(at_s, *pair, covers.x_m, covers.y_m, depth_m)
        self.first = self.first or overlap
        self._told(overlap)


def _cells_of(course: Course) -> tuple[Cell, Cell]:
    """Lower left and upper right cell of the area that a vehicle can cover."""
    end_x_m, end_y_m = course.end
    radius_m = (course.length_m + course.width_m) / 2.0
    low = (
        floor((min(course.x_m, end_x_m) - radius_m) / CELL_M),
        floor((min(course.y_m, end_y_m) - radius_m) / CELL_M),
    )
    high = (
        floor((max(course.x_m, end_x_m) + radius_m) / CELL_M),
        floor((max(course.y_m, end_y_m) + radius_m) / CELL_M),
    )
    return low, high
