"""Obstacles on the lanes: pallets, people, doors. They decide how far a vehicle can drive.

A door of the plant file (`dray_sim.bodies.doors`) shuts its lanes as a whole: vehicles wait before them. An obstacle
is a rectangle in the middle of a lane. It blocks every lane on which a vehicle would come too near to it, by geometry
alone. So it blocks both directions of a single track, and only its own lane of a road with two lanes.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import cos, hypot, sin

from dray.messages import Pose
from dray.plant import Plant
from dray.plant.floor.rectangles import Rectangle, gap_m
from dray.plant.model import VehicleType
from dray_sim.bodies.doors import Doors

Ends = tuple[str, str]
"""A lane in one direction, by its nodes."""


SIZES_M: Mapping[str, tuple[float, float]] = {"pallet": (1.2, 0.8), "person": (0.6, 0.6), "door": (0.2, 1.6)}
"""Sizes of obstacles. Length along the lane and width: a EUR pallet, a person with the room that they need, a door as
wide as a lane."""

CLEAR_M = 0.3
"""A vehicle stops so far before an obstacle."""

FALLS_M = 0.1
"""Gap between a vehicle and a pallet that it has lost."""

STEP_M = 0.05
"""Step of the search along a lane."""

REACH_M = 12.0
"""Lanes that are farther away from an obstacle than they are long, and this, do not touch it."""


def behind(pose: Pose, vehicle_m: float) -> Rectangle:
    """The area of a pallet that has slid off the back of a vehicle of this length."""
    length_m, width_m = SIZES_M["pallet"]
    back_m = vehicle_m / 2.0 + FALLS_M + length_m / 2.0
    x_m = pose.x_m - back_m * cos(pose.heading_rad)
    return Rectangle(x_m, pose.y_m - back_m * sin(pose.heading_rad), pose.heading_rad, length_m, width_m)


class Obstacles:
    """All obstacles of one floor.

    Args:
        plant: the lanes.
        doors: those of the plant file; None where none of them works.

    Attributes:
        doors: as given.
        shapes: the area that each covers, by the lane on which it was put.
    """

    def __init__(self, plant: Plant, doors: Doors | None = None) -> None:
        self.doors = doors
        self.shapes: dict[Ends, Rectangle] = {}
        self._plant = plant
        self._found: dict[tuple[Ends, float, float], dict[Ends, float]] = {}
        """By obstacle and size of a vehicle: the lanes that it obstructs, and how far a vehicle can drive on each."""

    def shape(self, lane: Ends, thing: str) -> Rectangle:
        """The area that a thing would cover in the middle of a lane.

        Raises:
            KeyError: there is no such lane.
        """
        road = self._plant.roads.lane(*lane)
        if road is None:
            raise KeyError(lane)
        start, end = self._plant.nodes[lane[0]], self._plant.nodes[lane[1]]
        middle = (start.x_m + end.x_m) / 2.0, (start.y_m + end.y_m) / 2.0
        return Rectangle(*middle, road.heading_rad, *SIZES_M[thing])

    def put(self, lane: Ends, thing: str) -> None:
        """Put something in the middle of a lane; it replaces the obstacle there."""
        self.lay(lane, self.shape(lane, thing))

    def lay(self, lane: Ends, shape: Rectangle) -> None:
        """Put something anywhere on a lane; it replaces the obstacle there."""
        self.take_away(lane)
        self.shapes[lane] = shape

    def take_away(self, lane: Ends) -> None:
        """Clear a lane; harmless when it is clear."""
        self.shapes.pop(lane, None)
        self._found = {key: found for key, found in self._found.items() if key[0] != lane}

    def room_m(self, start: str, end: str, kind: VehicleType, driven_m: float = 0.0) -> float | None:
        """How far a vehicle's middle may drive from the beginning of a lane; None where the lane is clear.

        Args:
            start: the lane's first node.
            end: its last.
            kind: of the vehicle.
            driven_m: the vehicle's present place: it leaves obstacles that it has passed behind.
        """
        rooms = [
            room_m
            for lane, shape in self.shapes.items()
            if (room_m := self._of(lane, shape, kind).get((start, end))) is not None
            and driven_m <= room_m + STEP_M
        ]
        return min(rooms, default=None)

    def touches(self, shape: Rectangle, x_m: float, y_m: float) -> bool:
        """Whether a thing would come too near to a vehicle of any type that stands at this spot and may turn there."""
        types = self._plant.vehicle_types.values()
        body_m = max((hypot(kind.length_m, kind.width_m) for kind in types), default=0.0) / 2.0
        return hypot(shape.x_m - x_m, shape.y_m - y_m) - body_m - shape.radius_m < CLEAR_M

    def _of(self, lane: Ends, shape: Rectangle, kind: VehicleType) -> dict[Ends, float]:
        key = (lane, kind.length_m, kind.width_m)
        found = self._found.get(key)
        if found is None:
            found = self._found[key] = self._look(shape, kind)
        return found

    def _look(self, shape: Rectangle, kind: VehicleType) -> dict[Ends, float]:
        found: dict[Ends, float] = {}
        nodes = self._plant.nodes
        turns_m = hypot(kind.length_m, kind.width_m)
        for lane in self._plant.roads.lanes:
            start, end = nodes[lane.start], nodes[lane.end]
            if hypot(start.x_m - shape.x_m, start.y_m - shape.y_m) > lane.length_m + REACH_M:
                continue
            along_x, along_y = (end.x_m - start.x_m) / lane.length_m, (end.y_m - start.y_m) / lane.length_m
            steps = int(lane.length_m / STEP_M)
            for step in (*range(steps + 1), steps + 1):
                run_m = min(step * STEP_M, lane.length_m)
                x_m, y_m = start.x_m + run_m * along_x, start.y_m + run_m * along_y
                body = Rectangle(x_m, y_m, lane.heading_rad, kind.length_m, kind.width_m)
                if run_m >= lane.length_m:
                    # A vehicle that may turn there needs room to turn.
                    body = Rectangle(x_m, y_m, lane.heading_rad, turns_m, turns_m)
                if gap_m(body, shape) < CLEAR_M:
                    last_m = run_m - STEP_M if run_m < lane.length_m else lane.length_m - turns_m
                    found[lane.start, lane.end] = max(0.0, last_m)
                    break
        return found
