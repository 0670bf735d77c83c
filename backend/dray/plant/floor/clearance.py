"""Distances between vehicles that stand, turn on the spot or drive, and the required ones."""

from __future__ import annotations

from math import cos, hypot, pi, sin

from dray.plant.floor.rectangles import Rectangle, gap_m
from dray.plant.layout import MARGIN_M, Size
from dray.plant.model import Node

CLEARANCE_M = 0.005
"""Smallest gap between two vehicles that right of way keeps apart: five times the rounding of stop points'
coordinates."""

SHARPEST_SIN = 0.2
"""Sine of the smallest angle between separate lanes. Lanes that leave a node at less than 12 degrees are one road,
and differ by their ends only."""

SAME_RAD = 1e-6
"""Smallest difference of directions at which a vehicle turns."""

STEP_M = 1e-4
"""Smallest step of a turning vehicle's corner."""


def clear_m(length_m: float, width_m: float, angle_rad: float) -> float:
    """Distance from a node along a lane at which a vehicle is clear of those on another lane at this angle.

    Args:
        length_m: of the largest vehicle.
        width_m: of the largest vehicle.
        angle_rad: between the two directions, from 0 to half a turn.
    """
    spacing_m = length_m / 2.0 + hypot(length_m, width_m) / 2.0 + MARGIN_M
    if cos(angle_rad) <= 0.0:
        return spacing_m
    half_m = width_m / 2.0
    beside_m = length_m / 2.0 + (half_m * (1.0 + cos(angle_rad)) + MARGIN_M) / max(
        sin(angle_rad), SHARPEST_SIN
    )
    return max(spacing_m, beside_m)


def turn_rad(before_rad: float, after_rad: float) -> float:
    """The shorter way round from one direction to another: below 0 to the right, half a turn to the left."""
    turned = (after_rad - before_rad + pi) % (2.0 * pi) - pi
    return pi if abs(turned + pi) < SAME_RAD else turned


def turning_gap_m(size: Size, node: Node, before_rad: float, after_rad: float, other: Rectangle) -> float:
    """Gap between a vehicle that turns on the spot and the area of another one; below 0 the depth of their overlap.

    The search ends at a gap below `CLEARANCE_M`, and returns that one.
    """
    turn = turn_rad(before_rad, after_rad)
    sign, most, turned = (1.0 if turn >= 0.0 else -1.0), abs(turn), 0.0
    least = float("inf")
    while True:
        covers = size.at(node, before_rad + sign * turned)
        gap = gap_m(covers, other)
        least = min(least, gap)
        if turned >= most or least < CLEARANCE_M:
            return least
        # A corner approaches no faster than it moves on its circle.
        turned = min(most, turned + max(gap - CLEARANCE_M, STEP_M) / covers.radius_m)
