"""What a vehicle sees in its way: told once when it stops before it, and once when that is gone. A door before which it stands sees it."""

from __future__ import annotations

from dray.body import WayBlocked, WayFree
from dray_sim.bodies.obstacles import Ends
from dray_sim.bodies.reporter import Reporter
from dray_sim.bodies.vehicle.travel import Travel


class ObstacleDetection:
    """Of one vehicle.

    Args:
        vehicle: its id.
        travel: its movement.
        reporter: its reports.
    """

    def __init__(self, vehicle: str, travel: Travel, reporter: Reporter) -> None:
        self._vehicle, self._travel, self._reporter = vehicle, travel, reporter
        self._seen: tuple[int, Ends] | None = None

    def look(self) -> None:
        """Its motion has changed, or what is in its way."""
        travel = self._travel
        if travel.doors is not None:
            travel.doors.heed(self._vehicle, travel.enters, travel.asks)
        lane = travel.blocked
        seen = None if travel.way is None or lane is None else (travel.way.order, lane)
        before, self._seen = self._seen, seen
        if seen == before:
            return
        if before is not None and travel.is_clear(before[1]):
            order, (start, end) = before
            self._reporter.say(WayFree(order=order, start=start, end=end))
        if seen is not None:
            order, (start, end) = seen
            self._reporter.say(WayBlocked(order=order, start=start, end=end, entered=travel.entered))
