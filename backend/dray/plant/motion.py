"""How long a vehicle takes for a way: pure kinematics in closed form.

A vehicle speeds up and brakes with one constant acceleration, keeps to the limit of every lane,
passes a bend at its turning speed at most, and stands at the beginning and at the end of a way.
The fastest motion within those bounds is a chain of trapezoids of speed over time, one per lane
(triangles where a lane is too short to reach the limit), and its duration is exact.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from math import sqrt

from dray.plant.model import VehicleType
from dray.plant.roads import DirectedLane, bends


def run_s(length_m: float, enter_mps: float, leave_mps: float, limit_mps: float, rate_mps2: float) -> float:
    """The least time for a straight run.

    Args:
        length_m: length of the run; long enough to get from `enter_mps` to `leave_mps`.
        enter_mps: speed at its beginning, at most `limit_mps`.
        leave_mps: speed at its end, at most `limit_mps`.
        limit_mps: highest speed allowed, above 0.
        rate_mps2: acceleration and braking, above 0.

    Returns:
        Seconds: speed up to the limit (or as far as the run allows), cruise, and brake.
    """
    squares = enter_mps * enter_mps + leave_mps * leave_mps
    top_mps = min(limit_mps, sqrt(0.5 * squares + rate_mps2 * length_m))
    if top_mps <= 0.0:
        return 0.0
    ramps_m = (top_mps * top_mps - 0.5 * squares) / rate_mps2
    ramps_s = (2.0 * top_mps - enter_mps - leave_mps) / rate_mps2
    # A rounding error may make the ramps longer than the run by its last bits.
    return ramps_s + max(0.0, length_m - ramps_m) / top_mps


def node_speeds_mps(lanes: Sequence[DirectedLane], vehicle: VehicleType) -> list[float]:
    """The highest speed at every node of a way that can be kept to from standstill to standstill.

    Args:
        lanes: the lanes of the way, each beginning where the one before it ends.
        vehicle: whose way it is.

    Returns:
        One speed per node, that is one more than lanes; first and last are 0.
    """
    twice_mps2 = 2.0 * vehicle.acceleration_mps2
    speeds = [0.0]
    for before, after in pairwise(lanes):
        reachable = sqrt(speeds[-1] * speeds[-1] + twice_mps2 * before.length_m)
        allowed = min(before.speed_limit_mps, after.speed_limit_mps, vehicle.max_speed_mps)
        if bends(before, after):
            allowed = min(allowed, vehicle.turn_speed_mps)
        speeds.append(min(reachable, allowed))
    speeds.append(0.0)
    for index in range(len(lanes) - 1, 0, -1):
        ahead_mps = speeds[index + 1]
        speeds[index] = min(speeds[index], sqrt(ahead_mps * ahead_mps + twice_mps2 * lanes[index].length_m))
    return speeds


def way_s(lanes: Sequence[DirectedLane], vehicle: VehicleType) -> float:
    """The least time for a way from standstill to standstill, in seconds; 0 for no lane at all."""
    if not lanes:
        return 0.0
    speeds = node_speeds_mps(lanes, vehicle)
    top_mps, rate_mps2 = vehicle.max_speed_mps, vehicle.acceleration_mps2
    return sum(
        run_s(lane.length_m, speeds[index], speeds[index + 1], min(top_mps, lane.speed_limit_mps), rate_mps2)
        for index, lane in enumerate(lanes)
    )
