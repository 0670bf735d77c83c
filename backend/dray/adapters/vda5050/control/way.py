"""The way that an agent has given, and how far its vehicle has come on it."""

from __future__ import annotations

from collections.abc import Collection
from itertools import pairwise

from dray.body import SLOWEST_FRAC, Drive
from dray.plant import Plant
from dray.plant.model import VehicleType


class Way:
    """One `Drive`.

    Args:
        drive: the instruction; `objection` has nothing against it.
        corners: nodes of the plant that are none for the vehicle, and where nobody stops.

    Attributes:
        passed: the index of the last node that was passed; -1 before the first one.
        released: how many nodes may be driven to.
        failures: orders in a row that have brought it no farther.
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
        """How many nodes an order may lead to: it never ends at a corner."""
        count = self.released
        while count > 1 and self.nodes[count - 1] in self._corners:
            count -= 1
        return count

    @property
    def base_end(self) -> str:
        """The last node that may be driven to; empty when it is passed."""
        return self.nodes[self.released - 1] if self.passed < self.released - 1 else ""

    def release(self, number: int, released: int) -> None:
        """Let more be driven; what is late or of another way changes nothing."""
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
        """The index up to which a base goes: one lane at least, then to the first node that is so far ahead, and no corner.

        Args:
            plant: the roads.
            start: the node from which is measured; -1 for the first one.
            ahead_m: how far ahead the base should reach.
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
        start: where a way must begin now.
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
    """Of a lane; 0 where there is none."""
    lane = plant.roads.lane(start, end)
    return 0.0 if lane is None else lane.length_m
