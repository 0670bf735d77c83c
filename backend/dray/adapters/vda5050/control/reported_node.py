"""Whether a vehicle can have reached the node that it reports as its last one: its position may contradict that.

A passed node frees the places behind it for other vehicles. So a vehicle that reports the node ahead, and stands where it stood, has not
passed it.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from math import hypot

from dray.adapters.vda5050.control.view import VehicleView
from dray.adapters.vda5050.profile import Profile
from dray.adapters.vda5050.wire.orders import Spot

AHEAD_M = 2.0
"""A vehicle counts a node as passed up to so far before it, at least: it cuts corners, and rounds."""


class ReportedNode:
    """The judgement for one vehicle.

    Args:
        view: its messages.
        profile: its tolerances.
    """

    def __init__(self, view: VehicleView, profile: Profile) -> None:
        self._view, self._profile = view, profile

    def gap_m(self, spots: Sequence[Spot], passed: int, index: int) -> float:
        """How far before a node of an order the vehicle is, in a straight line; 0 where its position does not contradict the node.

        Args:
            spots: the nodes of the order.
            passed: the index of the last node that it has surely passed.
            index: the index of the node that it reports.
        """
        view = self._view
        pose, frame = view.pose, view.names.frame(view.map_id)
        if pose is None or frame is None or not view.is_posed or not view.is_on_map:
            return 0.0
        if any(spot.map_id != view.map_id for spot in spots[passed:]):
            return 0.0  # It changes floors: the position on another map says nothing.
        here = frame.to_map(pose.x_m, pose.y_m)
        gap_m = hypot(here[0] - spots[index].x, here[1] - spots[index].y) * frame.scale
        if gap_m <= max(AHEAD_M, 2.0 * (self._profile.node_m + self._profile.deviation_m)):
            return 0.0
        before = _nearest(here, spots[passed : index + 1]) * frame.scale
        after = _nearest(here, spots[index:]) * frame.scale
        return gap_m if before <= self._profile.lane_m < after else 0.0


def _nearest(here: tuple[float, float], spots: Sequence[Spot]) -> float:
    """The distance to a line through these nodes."""
    if len(spots) < 2:
        return hypot(here[0] - spots[0].x, here[1] - spots[0].y)
    return min(_from_line(here, one, other) for one, other in pairwise(spots))


def _from_line(here: tuple[float, float], one: Spot, other: Spot) -> float:
    dx, dy = other.x - one.x, other.y - one.y
    square = dx * dx + dy * dy
    along = ((here[0] - one.x) * dx + (here[1] - one.y) * dy) / square if square else 0.0
    along = min(max(along, 0.0), 1.0)
    return hypot(one.x + along * dx - here[0], one.y + along * dy - here[1])
