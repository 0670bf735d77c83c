"""The true state of vehicles on a floor whose agents are elsewhere: overlaps, and the lanes that they entered."""

from __future__ import annotations

import asyncio
import logging
import time
from collections.abc import Mapping
from math import hypot

from dray.adapters.remote_body import BodySpec
from dray.adapters.telemetry.traffic_log import BEGUN, Line, TrafficLog
from dray.plant import Plant
from dray.plant.model import VehicleSpec
from dray.ports import Clock
from dray_sim.bodies.vehicle.course import Course
from dray_sim.bodies.vehicle.vehicle import SimVehicle
from dray_sim.checks.floor.overlaps import Overlap, Overlaps

LOOK_EVERY_S = 1.0
"""Interval at which unchanged motion is judged up to now."""

log = logging.getLogger(__name__)


class FloorMonitor:
    """Judges the bodies of a floor by their rectangles alone, and says so in the log.

    Args:
        plant: where nodes are, and how long vehicles.
        vehicles: the bodies, by the vehicle's id; further ones may come.
        clock: the plant's clock.
        lines: where it is written down which lanes they enter, if anywhere.

    Attributes:
        overlaps: how often two vehicles came into one spot.
    """

    def __init__(
        self,
        plant: Plant,
        vehicles: Mapping[str, SimVehicle],
        clock: Clock,
        lines: TrafficLog | None = None,
    ) -> None:
        self._plant = plant
        self._length_m = max(kind.length_m for kind in plant.vehicle_types.values())
        self._vehicles, self._clock, self._lines = vehicles, clock, lines
        self._overlaps = Overlaps(vehicles, strict=False, told=self._on_overlap)
        self._lanes: dict[str, tuple[str, str] | None] = {}
        if lines is not None:
            lines.write(Line(time.monotonic(), "", did=BEGUN))
        self._watch_lanes()

    @property
    def overlaps(self) -> int:
        return self._overlaps.count

    def occupied(self, spec: BodySpec) -> str:
        """Why a vehicle cannot be put down: another one is within its length of that node; empty when none is."""
        if not isinstance(spec, VehicleSpec) or spec.node not in self._plant.nodes:
            return ""
        node = self._plant.nodes[spec.node]
        for name, vehicle in self._vehicles.items():
            pose = vehicle.sense().pose
            if hypot(pose.x_m - node.x_m, pose.y_m - node.y_m) < self._length_m:
                return f"{name} is at {spec.node}; put {spec.id} down where nobody is, nor drives to"
        return ""

    async def run(self) -> None:
        """Judge until cancelled."""
        while True:
            await asyncio.sleep(LOOK_EVERY_S)
            self.look()

    def look(self) -> None:
        """Judge unchanged motion up to now."""
        self._watch_lanes()
        self._overlaps.check_end(self._clock.now_s())

    def _watch_lanes(self) -> None:
        for name, vehicle in self._vehicles.items():
            if self._lines is not None and name not in self._lanes:
                self._lanes[name] = None
                vehicle.watch_course(self._on_course)

    def _on_course(self, vehicle: str, course: Course) -> None:
        if self._lines is None or self._lanes.get(vehicle) == course.lane:
            return
        self._lanes[vehicle] = course.lane
        if course.lane is not None:
            self._lines.write(Line(time.monotonic(), vehicle, lane=course.lane))

    def _on_overlap(self, overlap: Overlap) -> None:
        log.error("%s, at %.3f s of the plant's clock", overlap, overlap.at_s)
        if self._lines is not None:
            self._lines.write(Line(time.monotonic(), overlap.first, overlap=overlap.second))
