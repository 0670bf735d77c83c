"""The agent's way, and its vehicle's progress on it."""

from __future__ import annotations

from collections.abc import Collection
from itertools import pairwise

from dray.body import SLOWEST_FRAC, Drive
from dray.plant import Plant
from dray.plant.model import VehicleType


class Way:
    """One `Drive`.

    Args:
        drive: the instruction, valid by `objection`.
        corners: nodes that the vehicle does not know, where no vehicle stops.

    Attributes:
        passed: the index of the last passed node; -1 before the first one.
        released: number of released nodes.
        failures: consecutive orders without progress.
    """

    def __init__(self, drive: Drive, corners: Collection[str] = ()) -> None:
        self._corners = corners
        self.number, self.nodes, self.limits_mps = drive.order, drive.nodes, drive.limits_mps
        self.released = drive.released
        self.passed = -1
        self.failures = 0

    @property
    def last(self) -> int:
        return len(self.nodes) - 1

    @property
    def drivable(self) -> int:
        """Number of nodes that an order may lead to: it never ends at a corner."""
        count = self.released
        while count > 1 and self.nodes[count - 1] in self._corners:
            count -= 1
        return count

    @property
    def base_end(self) -> str:
        """The last released node; empty when it is passed."""
        return self.nodes[self.released - 1] if self.passed < self.released - 1 else ""

    def release(self, number: int, released: int) -> None:
        """Release more; a late release, or one of another way, changes nothing."""
        if number == self.number:
            self.released = min(max(self.released, released), len(self.nodes))

    def speed_mps(self, plant: Plant, index: int, kind: VehicleType, speed_frac: float) -> float | None:
        """The limit on the lane to a node of the way."""
        if index < 1:
            return None
        lane = plant.roads_of(kind.id).lane(self.nodes[index - 1], self.nodes[index])
        own_mps = kind.max_speed_mps * max(speed_frac, SLOWEST_FRAC)
        told_mps = self.limits_mps[index - 1] if self.limits_mps else None
        limits = [own_mps, *([told_mps] if told_mps is not None else [])]
        return min([*limits, lane.speed_limit_mps] if lane is not None else limits)

    def reach(self, plant: Plant, start: int, ahead_m: float) -> int:
        """The last index of a base: at least one lane, then to the first node at that distance that is no corner.

        Args:
            plant: the roads.
            start: the node from which the distance counts; -1 for the first one.
            ahead_m: the wanted length of the base.
        """
        index = min(start + 1, self.last)
        gone_m = 0.0 if index < 1 else length_m(plant, self.nodes[index - 1], self.nodes[index])
        end = self.drivable
        while index + 1 < end and (gone_m < ahead_m or self.nodes[index] in self._corners):
            gone_m += length_m(plant, self.nodes[index], self.nodes[index + 1])
            index += 1
        return min(index, end - 1)


def objection(drive: Drive, start: str, plant: Plant, kind: str) -> str:
    """Why a way cannot be driven; empty when it can.

    Args:
        drive: the instruction.
        start: the required first node of a way now.
        plant: the roads.
        kind: the type of the vehicle.
    """
    nodes = drive.nodes
    if not nodes or nodes[0] != start:
        return f"the way must begin at {start}"
    if not 1 <= drive.released <= len(nodes):
        return f"{drive.released} of {len(nodes)} nodes released"
    if drive.limits_mps and len(drive.limits_mps) != len(nodes) - 1:
        return f"{len(drive.limits_mps)} speed limits for {len(nodes) - 1} lanes"
    for one, other in pairwise(nodes):
        if plant.roads_of(kind).lane(one, other) is None:
            return f"no lane from {one} to {other}"
    return ""


def length_m(plant: Plant, start: str, end: str) -> float:
    """The length of a lane; 0 where there is none."""
    lane = plant.roads.lane(start, end)
    return 0.0 if lane is None else lane.length_m
