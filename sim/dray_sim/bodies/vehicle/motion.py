"""How a vehicle moves along a way: speed profiles of constant acceleration, in closed form.

A way is a row of straight lanes. `plan` makes the fastest profile over it that keeps every limit; `brake` stops as
soon as possible. A `Profile` gives the place at a time, and the time at a place, without stepping through time. So a
simulated vehicle needs no ticks. `dray_sim.bodies.vehicle.way` and `dray_sim.bodies.vehicle.vehicle` choose the lanes
of the way and act at its nodes.

Theory of operation: under a constant acceleration `a` the square of the speed grows by `2 a` per metre. A backward
pass over the lanes' ends lowers each speed so that the vehicle can brake for the next ones. A forward pass lowers it
to a reachable one. Between two ends it accelerates, keeps the limit and brakes.

A vehicle that learns too late of a stop or a turn brakes harder than its usual rate: staying on the road comes before
comfort. A vehicle that learns of a lower limit brakes normally, and exceeds that limit until it has done so.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from math import sqrt
from typing import NamedTuple

SHORT_M = 1e-9
"""A stretch that is shorter than a nanometre is rounding: no segment is made of it."""


class Stretch(NamedTuple):
    """Lanes ahead, as `plan` needs them; all of one length, one entry per lane."""

    lengths_m: Sequence[float]
    """Lengths of the lanes, or of their remaining parts; not negative."""
    limits_mps: Sequence[float]
    """The highest speed on each lane."""
    caps_mps: Sequence[float]
    """The highest speed at the end of each lane, infinite where there is no turn; the last is ignored."""


class Profile:
    """Place over time; both count from the beginning of the profile.

    Invariants: the place never falls, place and speed are continuous, the last speed is 0.

    Args:
        length_m: where it will stand at the end. Given beforehand, because a sum of segments has
            rounding in it.

    Attributes:
        length_m: as given.
        duration_s: when it stands there.
    """

    __slots__ = ("_begins_m", "_begins_s", "_end_m", "_rates_mps2", "_speeds_mps", "duration_s", "length_m")

    def __init__(self, length_m: float) -> None:
        self.length_m = length_m
        self.duration_s = 0.0
        self._end_m = 0.0
        # One entry per segment, as columns: bisection needs them so, and they are quicker to make.
        self._begins_s: list[float] = []
        self._begins_m: list[float] = []
        self._speeds_mps: list[float] = []
        self._rates_mps2: list[float] = []

    def append(self, length_m: float, from_mps: float, to_mps: float) -> None:
        """Append `length_m` with a constant rate of speed change; for functions that make profiles."""
        if length_m <= SHORT_M:
            return
        duration_s = 2.0 * length_m / (from_mps + to_mps)
        self._begins_s.append(self.duration_s)
        self._begins_m.append(self._end_m)
        self._speeds_mps.append(from_mps)
        self._rates_mps2.append((to_mps - from_mps) / duration_s)
        self.duration_s += duration_s
        self._end_m += length_m

    @property
    def top_mps(self) -> float:
        """The highest speed in it."""
        return max(self._speeds_mps, default=0.0)

    def at(self, time_s: float) -> tuple[float, float]:
        """Place in metres and speed in metres per second at `time_s`, not before the beginning."""
        if time_s >= self.duration_s:
            return self.length_m, 0.0
        i = bisect_right(self._begins_s, time_s) - 1
        dt_s = time_s - self._begins_s[i]
        speed_mps, rate_mps2 = self._speeds_mps[i], self._rates_mps2[i]
        place_m = self._begins_m[i] + (speed_mps + 0.5 * rate_mps2 * dt_s) * dt_s
        return min(place_m, self.length_m), max(speed_mps + rate_mps2 * dt_s, 0.0)

    def time_at(self, place_m: float) -> float:
        """When `place_m`, not before the beginning, is reached; infinity beyond the end."""
        if place_m >= self.length_m - SHORT_M:
            return self.duration_s if place_m <= self.length_m + SHORT_M else float("inf")
        i = max(bisect_right(self._begins_m, place_m) - 1, 0)  # Rounding may put it before the beginning.
        run_m = place_m - self._begins_m[i]
        if run_m <= 0.0:
            return self._begins_s[i]
        speed_mps = self._speeds_mps[i]
        root_mps = sqrt(max(speed_mps * speed_mps + 2.0 * self._rates_mps2[i] * run_m, 0.0))
        # The root in this form loses no digits where the acceleration is small, and is right for none.
        return self._begins_s[i] + 2.0 * run_m / (speed_mps + root_mps)


STANDSTILL = Profile(0.0)
"""The profile of a vehicle that stands."""


def plan(stretch: Stretch, speed_mps: float, acceleration_mps2: float) -> Profile:
    """Plan the fastest way over some lanes, from the present speed to a stop at their end.

    Args:
        stretch: the lanes; at least one.
        speed_mps: the speed at the beginning. The vehicle brakes when it is above the first limit.
        acceleration_mps2: speeding up and braking; exceeded only to stop or to turn in time.
    """
    lengths_m, limits_mps, caps_mps = stretch
    doubled_mps2 = 2.0 * acceleration_mps2
    square = speed_mps * speed_mps
    squares = hard = _ends(lengths_m, limits_mps, caps_mps, doubled_mps2)
    if square > squares[0]:
        no_limits_mps = [float("inf")] * len(lengths_m)
        hard = _ends(lengths_m, no_limits_mps, caps_mps, doubled_mps2)
    profile = Profile(sum(lengths_m))
    for i, length_m in enumerate(lengths_m):
        change = doubled_mps2 * length_m
        end = squares[i + 1]
        if square - change > end:
            # Too fast: brake as usual if turns and the stop allow it, else as hard as they demand.
            end = min(square - change, hard[i + 1])
        end = min(end, square + change)
        _append_lane(profile, length_m, limits_mps[i], (square, end), doubled_mps2)
        square = end
    return profile


def brake(speed_mps: float, deceleration_mps2: float, room_m: float) -> Profile:
    """Stop as soon as possible, and within `room_m`."""
    length_m = min(speed_mps * speed_mps / (2.0 * deceleration_mps2), room_m)
    if length_m <= SHORT_M:
        return STANDSTILL
    profile = Profile(length_m)
    profile.append(length_m, speed_mps, 0.0)
    return profile


def _ends(
    lengths_m: Sequence[float], limits_mps: Sequence[float], caps_mps: Sequence[float], doubled_mps2: float
) -> list[float]:
    """The squares of the highest speeds from which everything ahead can be kept, at all lanes' ends."""
    squares = [0.0] * (len(lengths_m) + 1)
    square = 0.0
    for i in range(len(lengths_m) - 1, -1, -1):
        limit_mps = limits_mps[i]
        if i:
            limit_mps = min(limit_mps, limits_mps[i - 1], caps_mps[i - 1])
        square = min(square + doubled_mps2 * lengths_m[i], limit_mps * limit_mps)
        squares[i] = square
    return squares


def _append_lane(
    profile: Profile, length_m: float, limit_mps: float, squares: tuple[float, float], doubled_mps2: float
) -> None:
    """Add one lane, entered and left with the squares of these speeds: as fast as possible between."""
    square, end = squares
    speed_mps, end_mps = sqrt(square), sqrt(end)
    if end <= square - doubled_mps2 * length_m:
        profile.append(length_m, speed_mps, end_mps)  # There is room for braking only, or not even for that.
        return
    limit = limit_mps * limit_mps
    if square > limit:
        slower_m = (square - limit) / doubled_mps2
        profile.append(slower_m, speed_mps, limit_mps)
        length_m -= slower_m
        square, speed_mps = limit, limit_mps
    peak = min(limit, 0.5 * (square + end + doubled_mps2 * length_m))
    peak_mps = sqrt(peak)
    up_m, down_m = (peak - square) / doubled_mps2, (peak - end) / doubled_mps2
    profile.append(up_m, speed_mps, peak_mps)
    profile.append(length_m - up_m - down_m, peak_mps, peak_mps)
    profile.append(down_m, peak_mps, end_mps)
