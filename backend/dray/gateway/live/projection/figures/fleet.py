"""How the fleet is used: what vehicles spend their time on, and how far they drive, empty and loaded."""

from __future__ import annotations

from math import hypot

from msgspec import UNSET

from dray.gateway.live.projection.figures.sliding_window import Window
from dray.gateway.live.projection.figures.time_use import HOUR_SLOTS, SILENCE_S, TimeUse
from dray.messages import AtvHeartbeat, AtvStatus

MOVING, WAITING, CHARGING, BLOCKED, IDLE = "moving", "waiting", "charging", "blocked", "idle"
OUT_OF_SERVICE = "out_of_service"

DOINGS = (MOVING, WAITING, CHARGING, BLOCKED, IDLE, OUT_OF_SERVICE)
"""What a vehicle may do. It waits at work: while it loads, unloads, or has no way. It is blocked when it was
stopped, or has a problem. It is out of service by a person's word, once it carries nothing any more."""


_STOPPED, _ERROR, _CHARGING, _WORKING = (
    AtvStatus.STOPPED,
    AtvStatus.ERROR,
    AtvStatus.CHARGING,
    AtvStatus.WORKING,
)
# Looked up once: Python 3.11 finds a member of an enumeration ten times slower than a name of the module.

CHARGED_FRAC = 0.05
"""A battery that shows so much more than it did was charged, or another one: gauges wander by less."""

LOOSE_FRAC, LOOSE_M = 1.5, 5.0
"""What clocks, rounding and a push by hand add to the way of a vehicle at top speed."""


class Fleet:
    """The use of all vehicles.

    Args:
        top_mps: no vehicle is faster: whoever tells of more has not driven it.

    Attributes:
        use: their time.
        empty_m: driven without a load, since the beginning.
        loaded_m: driven with one.
        energy_wh: taken from batteries since the beginning, by what these show; a charger's losses are not in it.
    """

    def __init__(self, top_mps: float) -> None:
        self._top_mps = top_mps
        self.use = TimeUse(DOINGS, lasting=OUT_OF_SERVICE)
        self.empty_m = self.loaded_m = self.energy_wh = 0.0
        self._lowest_frac: dict[str, float] = {}
        """By vehicle: what its battery has shown at the least since it was charged. So a gauge that wanders takes nothing twice."""
        self._empty, self._loaded = Window(*HOUR_SLOTS), Window(*HOUR_SLOTS)

    def fold(self, last: AtvHeartbeat | None, heartbeat: AtvHeartbeat, battery_wh: float = 0.0) -> None:
        """Take a heartbeat in.

        Args:
            last: what the vehicle said before; None for nothing.
            heartbeat: what it says now.
            battery_wh: what its battery holds; 0 where nobody knows.
        """
        self._take(heartbeat, battery_wh)
        self.use.tell(heartbeat.atv, doing(heartbeat), heartbeat.at_s)
        if last is not None and 0 < heartbeat.at_s - last.at_s <= SILENCE_S:
            self._drive(last, heartbeat)

    def empty_frac(self, now_s: float) -> float | None:
        """Part of the way of the last hour that was driven without a load; None when nobody drove."""
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
        # Lanes are straight and heartbeats frequent: what a corner between two of them adds is little.
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
