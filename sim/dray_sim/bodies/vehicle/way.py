"""A way through the plant as a vehicle drives it: points, the lanes between them, places in metres.

Immutable: how far the vehicle has come, and how far it may go, is the vehicle's own knowledge. A place is counted in
metres from the first point. A vehicle that is given a way while it is on a lane finishes that lane first. The lane
then leads the way, and the first point is where it began.
"""

from __future__ import annotations

from itertools import pairwise

from dray.messages import Pose
from dray.plant import DirectedLane, Plant, Roads, bends
from dray_sim.bodies.vehicle.motion import Stretch


class Way:
    """The way of one `Drive`.

    Args:
        order: the number of the instruction.
        points: where it leads through; the first one is where the first lane begins.
        points: of the way; the first one is where the first lane begins.
        lead: how many points come before `Drive.nodes[0]`: 1 when a lane has to be finished, else 0.
        turn_mps: the highest speed in a sharp bend.
        limits_mps: speed limits that replace those of the lanes, one per lane; None keeps a lane's own limit, and an
            empty sequence keeps all.
    """

    __slots__ = (
        "_caps_mps",
        "_lanes",
        "_limits_mps",
        "_told_mps",
        "_turn_mps",
        "lead",
        "order",
        "places_m",
        "points",
    )

    def __init__(
        self,
        order: int,
        points: tuple[str, ...],
        lanes: list[DirectedLane],
        lead: int,
        turn_mps: float,
        limits_mps: tuple[float | None, ...] = (),
    ) -> None:
        self.order, self.points, self.lead = order, points, lead
        self._lanes = lanes
        self._told_mps = limits_mps or (None,) * len(lanes)
        self._limits_mps = [
            lane.speed_limit_mps if told is None else min(lane.speed_limit_mps, told)
            for lane, told in zip(lanes, self._told_mps, strict=True)
        ]
        self._turn_mps = turn_mps
        free_mps = float("inf")
        self._caps_mps = [turn_mps if bends(before, after) else free_mps for before, after in pairwise(lanes)]
        self._caps_mps.append(0.0)
        self.places_m = [0.0]
        """Place of every point."""
        place_m = 0.0
        for lane in lanes:
            place_m += lane.length_m
            self.places_m.append(place_m)

    @property
    def last(self) -> int:
        """The index of the last point."""
        return len(self.points) - 1

    def cut(self, point: int) -> Way:
        """The same way, ending at a point."""
        told_mps = self._told_mps[:point]
        return Way(
            self.order, self.points[: point + 1], self._lanes[:point], self.lead, self._turn_mps, told_mps
        )

    def limit_on(self, lane: int) -> float | None:
        """The speed limit given for a lane, counted as its first point; None for nothing."""
        return self._told_mps[lane]

    def heading_rad(self, lane: int) -> float:
        """The direction of a lane, counted as its first point."""
        return self._lanes[lane].heading_rad

    def pose(self, plant: Plant, lane: int, place_m: float) -> Pose:
        """Pose of a vehicle at `place_m` on a lane."""
        road = self._lanes[lane]
        start, end = plant.nodes[road.start], plant.nodes[road.end]
        part = min(max((place_m - self.places_m[lane]) / road.length_m, 0.0), 1.0)
        return Pose(
            x_m=start.x_m + part * (end.x_m - start.x_m),
            y_m=start.y_m + part * (end.y_m - start.y_m),
            heading_rad=road.heading_rad,
        )

    def ahead(self, lane: int, place_m: float, to: int, top_mps: float) -> Stretch:
        """The stretch between a vehicle and a point.

        Args:
            lane: the lane that the vehicle is on, or at whose beginning it stands.
            place_m: its place on the way.
            to: the index of the point.
            top_mps: the vehicle's own limit.
        """
        places_m = self.places_m
        lengths_m = [places_m[i + 1] - places_m[i] for i in range(lane, to)]
        lengths_m[0] = max(places_m[lane + 1] - place_m, 0.0)
        limits_mps = [min(limit_mps, top_mps) for limit_mps in self._limits_mps[lane:to]]
        return Stretch(lengths_m, limits_mps, self._caps_mps[lane:to])


def join(roads: Roads, points: tuple[str, ...]) -> list[DirectedLane] | str:
    """The lanes along some points; an error in words when one of them is missing."""
    lanes = []
    for start, end in pairwise(points):
        lane = roads.lane(start, end)
        if lane is None:
            return f"no lane from {start} to {end}"
        lanes.append(lane)
    return lanes
