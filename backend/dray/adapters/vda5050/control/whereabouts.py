"""A vehicle's position on the plant's roads: at a node, or between two."""

from __future__ import annotations

from itertools import pairwise
from math import hypot

from dray.adapters.vda5050.profile import Profile
from dray.messages import Pose
from dray.messages.base import Part
from dray.plant import Plant

PAST_M = 0.05
"""Maximum `distanceSinceLastNode` of a line-following vehicle that is still at the node."""


class Stand(Part, frozen=True):
    """A position on the roads."""

    node: str
    """The present node, or the last one left."""
    ahead: str = ""
    """The end of its lane; empty at a node."""


class Whereabouts:
    """Finds a pose on the roads of a plant.

    Args:
        plant: the roads.
        profile: the tolerances.
    """

    def __init__(self, plant: Plant, profile: Profile) -> None:
        self._plant, self._profile = plant, profile

    def find(
        self, pose: Pose | None, said: str, course: tuple[str, ...] = (), *, is_past: bool = False
    ) -> Stand | None:
        """The vehicle's position on the roads.

        Args:
            pose: in the plant's frame; None without a report.
            said: `lastNodeId`; believed when the pose agrees, or when there is none.
            course: the next nodes to drive to, in order.
            is_past: whether a line-following vehicle has left its last node: it cannot go back there, however near.

        Returns:
            None when it is at no place of the plant, or its position is unknown.
        """
        nodes = self._plant.nodes
        if pose is None:
            return Stand(said) if said in nodes else None
        nearest = min(nodes.values(), key=lambda node: hypot(node.x_m - pose.x_m, node.y_m - pose.y_m))
        if hypot(nearest.x_m - pose.x_m, nearest.y_m - pose.y_m) <= self._profile.node_m:
            if nearest.id != said or not is_past:
                return Stand(nearest.id)
            left = self._on_lane(pose, said, course[course.index(said) :] if said in course else ())
            return left if left is not None and left.node == said else Stand(said)
        return self._on_lane(pose, said, course)

    def gap_m(self, pose: Pose | None, node: str) -> float:
        """The distance to a node; 0 without a pose."""
        if pose is None:
            return 0.0
        spot = self._plant.nodes[node]
        return hypot(spot.x_m - pose.x_m, spot.y_m - pose.y_m)

    def _on_lane(self, pose: Pose, said: str, course: tuple[str, ...]) -> Stand | None:
        """Search the lane that it was driving, then the lanes of the last node, then the nearest."""
        due = set(pairwise(course))
        best: tuple[int, float] | None = None
        found = None
        for lane in self._plant.roads.lanes:
            gap_m = self._from_lane_m(pose, lane.start, lane.end)
            if gap_m > self._profile.lane_m:
                continue
            rank = (0 if (lane.start, lane.end) in due else 1 if lane.start == said else 2, gap_m)
            if best is None or rank < best:
                best, found = rank, Stand(lane.start, lane.end)
        return found

    def _from_lane_m(self, pose: Pose, start: str, end: str) -> float:
        one, other = self._plant.nodes[start], self._plant.nodes[end]
        dx_m, dy_m = other.x_m - one.x_m, other.y_m - one.y_m
        square = dx_m * dx_m + dy_m * dy_m
        along = ((pose.x_m - one.x_m) * dx_m + (pose.y_m - one.y_m) * dy_m) / square if square else 0.0
        along = min(max(along, 0.0), 1.0)
        return hypot(one.x_m + along * dx_m - pose.x_m, one.y_m + along * dy_m - pose.y_m)
