"""The duration of a vehicle's way: pure kinematics in closed form.

A vehicle speeds up and brakes with one constant acceleration, keeps to the limit of every lane, and passes a bend at
its turning speed at most. It stands at both ends of a way, and before a door until that is open. The fastest motion
within those bounds is a chain of trapezoids of speed over time, one per run. A run that is too short to reach its
limit has a triangle. The duration is exact.

A *run* is a piece of a way with constant properties: straight lanes of one limit in a row. It is a tuple of its
length (m), its speed limit (m/s) and the highest speed at its end (m/s). It is not a class, because a way into a
large plant makes a million of them.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import sqrt

from dray.plant.model import VehicleType
from dray.plant.roads import DirectedLane, bends

Run = tuple[float, float, float]
"""Length in metres, speed limit and highest speed at the end in metres per second."""


def limit_mps(lane: DirectedLane, vehicle: VehicleType) -> float:
    """The highest speed of a type of vehicle on a lane."""
    return min(lane.speed_limit_mps, vehicle.max_speed_mps)


def lane_s(lane: DirectedLane, vehicle: VehicleType) -> float:
    """The cost of a lane: its time at the highest speed there, and that of its door."""
    return lane.length_m / limit_mps(lane, vehicle) + lane.opening_s


def joint_mps(before: DirectedLane, after: DirectedLane, vehicle: VehicleType) -> float:
    """The highest speed at the node between two lanes; 0 before a door."""
    if after.opening_s:
        return 0.0
    allowed = min(limit_mps(before, vehicle), limit_mps(after, vehicle))
    return min(allowed, vehicle.turn_speed_mps) if bends(before, after) else allowed


def runs_s(runs: Sequence[Run], rate_mps2: float) -> float:
    """The least time from standstill at the beginning of the first run to standstill at the end of the last.

    Args:
        runs: in the order of driving; the last one ends at 0 m/s in any case.
        rate_mps2: acceleration and braking, above 0.

    Returns:
        Seconds; 0 for no run at all.
    """
    ends = _end_squares(runs, 2.0 * rate_mps2)
    duration_s, square = 0.0, 0.0
    for (length_m, top_mps, _), allowed in zip(runs, ends, strict=True):
        end = min(allowed, square + 2.0 * rate_mps2 * length_m)
        duration_s += _run_s(length_m, square, end, top_mps, rate_mps2)
        square = end
    return duration_s


def _end_squares(runs: Sequence[Run], twice_mps2: float) -> list[float]:
    """The squares of the speeds at the ends of runs from which all that comes after can be kept."""
    squares = [0.0] * len(runs)
    square = 0.0
    for index in range(len(runs) - 1, 0, -1):
        square = min(square + twice_mps2 * runs[index][0], runs[index - 1][2] ** 2)
        squares[index - 1] = square
    return squares


def _run_s(length_m: float, enter: float, leave: float, top_mps: float, rate_mps2: float) -> float:
    """The least time for one run between two speeds, given as their squares, that it can join."""
    peak = min(top_mps * top_mps, 0.5 * (enter + leave) + rate_mps2 * length_m)
    peak_mps = sqrt(peak)
    ramps_m = (peak - 0.5 * (enter + leave)) / rate_mps2
    ramps_s = (2.0 * peak_mps - sqrt(enter) - sqrt(leave)) / rate_mps2
    # A rounding error may make the ramps longer than the run by its last bits.
    return ramps_s + max(0.0, length_m - ramps_m) / peak_mps
