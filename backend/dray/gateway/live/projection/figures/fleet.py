"""Fleet use: how vehicles spend their time, and the metres driven empty and loaded."""

from __future__ import annotations

from math import hypot

from msgspec import UNSET

from dray.gateway.live.projection.figures.sliding_window import Window
from dray.gateway.live.projection.figures.time_use import HOUR_SLOTS, SILENCE_S, TimeUse
from dray.messages import AtvHeartbeat, AtvStatus

MOVING, WAITING, CHARGING, BLOCKED, IDLE = "moving", "waiting", "charging", "blocked", "idle"
OUT_OF_SERVICE = "out_of_service"

DOINGS = (MOVING, WAITING, CHARGING, BLOCKED, IDLE, OUT_OF_SERVICE)
"""What a vehicle may do. It waits at work while it loads, unloads or has no way. It is blocked when stopped
or in error. It is out of service by a person's word, once it carries nothing."""


_STOPPED, _ERROR, _CHARGING, _WORKING = (
    AtvStatus.STOPPED,
    AtvStatus.ERROR,
    AtvStatus.CHARGING,
    AtvStatus.WORKING,
)
# Looked up once: Python 3.11 finds an enumeration member ten times slower than a module's name.

CHARGED_FRAC = 0.05
"""Minimum rise of the shown level that means a charged or replaced battery: gauges wander by less."""

LOOSE_FRAC, LOOSE_M = 1.5, 5.0
"""Tolerances that clocks, rounding and a push by hand add to the way of a vehicle at top speed."""


class Fleet:
    """The use of all vehicles.

    Args:
        top_mps: top speed of the fastest vehicle; longer ways are ignored.

    Attributes:
        use: the vehicles' time.
        empty_m: metres driven without a load since the beginning.
        loaded_m: metres driven with a load since the beginning.
        energy_wh: energy taken from batteries since the beginning, by their gauges; without charger losses.
    """

    def __init__(self, top_mps: float) -> None:
        self._top_mps = top_mps
        self.use = TimeUse(DOINGS, lasting=OUT_OF_SERVICE)
        self.empty_m = self.loaded_m = self.energy_wh = 0.0
        self._lowest_frac: dict[str, float] = {}
        """Per vehicle, the lowest battery level since its last charge, so that a wandering gauge counts
        nothing twice."""
        self._empty, self._loaded = Window(*HOUR_SLOTS), Window(*HOUR_SLOTS)

    def fold(self, last: AtvHeartbeat | None, heartbeat: AtvHeartbeat, battery_wh: float = 0.0) -> None:
        """Take a heartbeat in.

        Args:
            last: the vehicle's previous heartbeat; None if there was none.
            heartbeat: the new heartbeat.
            battery_wh: battery capacity; 0 if unknown.
        """
        self._take(heartbeat, battery_wh)
        self.use.tell(heartbeat.atv, doing(heartbeat), heartbeat.at_s)
        if last is not None and 0 < heartbeat.at_s - last.at_s <= SILENCE_S:
            self._drive(last, heartbeat)

    def empty_frac(self, now_s: float) -> float | None:
        """Fraction of the last hour's way driven without a load; None when no vehicle drove."""
        (empty_m,), (loaded_m,) = self._empty.sums(now_s, 1), self._loaded.sums(now_s, 1)
        return empty_m / (empty_m + loaded_m) if empty_m + loaded_m > 0 else None

    def _take(self, heartbeat: AtvHeartbeat, battery_wh: float) -> None:
        frac, lowest_frac = heartbeat.battery_frac, self._lowest_frac.get(heartbeat.atv)
        if lowest_frac is None or heartbeat.status is _CHARGING or frac > lowest_frac + CHARGED_FRAC:
            self._lowest_frac[heartbeat.atv] = frac
        elif frac < lowest_frac:
            self.energy_wh += (lowest_frac - frac) * battery_wh
            self._lowest_frac[heartbeat.atv] = frac

    def _drive(self, last: AtvHeartbeat, heartbeat: AtvHeartbeat) -> None:
        # Lanes are straight and heartbeats frequent: a corner between two of them adds little.
        here, there = heartbeat.pose, last.pose
        way_m = hypot(here.x_m - there.x_m, here.y_m - there.y_m)
        most_m = LOOSE_FRAC * self._top_mps * (heartbeat.at_s - last.at_s) + LOOSE_M
        if not 0.0 < way_m <= most_m:
            return
        if last.load:
            self.loaded_m += way_m
            self._loaded.add(heartbeat.at_s, way_m)
        else:
            self.empty_m += way_m
            self._empty.add(heartbeat.at_s, way_m)


def doing(heartbeat: AtvHeartbeat) -> str:
    """What a vehicle does."""
    if heartbeat.out_of_service is not UNSET and heartbeat.task is None:
        return OUT_OF_SERVICE
    status = heartbeat.status
    if status is _STOPPED or status is _ERROR:
        return BLOCKED
    if status is _CHARGING:
        return CHARGING
    if heartbeat.speed_mps:
        return MOVING
    return WAITING if status is _WORKING else IDLE
