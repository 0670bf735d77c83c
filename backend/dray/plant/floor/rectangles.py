"""Rectangles on the floor, as areas of vehicles: the gap between two, and the area of a driven lane."""

from __future__ import annotations

from math import atan2, cos, hypot, sin

import msgspec

from dray.plant.model import Node


class Rectangle(msgspec.Struct, frozen=True, gc=False):
    """Its middle, its direction (rad, counter-clockwise from the x axis), and its length along it (m)."""

    x_m: float
    y_m: float
    heading_rad: float
    length_m: float
    width_m: float

    @property
    def radius_m(self) -> float:
        """Radius of the circle around it."""
        return hypot(self.length_m, self.width_m) / 2.0


def gap_m(first: Rectangle, second: Rectangle) -> float:
    """Lower bound of the distance between two rectangles; below 0 the depth of their overlap.

    Their shadows are compared along each of the four directions of their sides; they overlap where the shadows do in
    all four (separating axes). The true distance is this or more, where the nearest points are two corners.
    """
    dx_m, dy_m = second.x_m - first.x_m, second.y_m - first.y_m
    ahead_x, ahead_y = cos(first.heading_rad), sin(first.heading_rad)
    other_x, other_y = cos(second.heading_rad), sin(second.heading_rad)
    along, across = abs(ahead_x * other_x + ahead_y * other_y), abs(ahead_x * other_y - ahead_y * other_x)
    length1_m, width1_m = first.length_m / 2.0, first.width_m / 2.0
    length2_m, width2_m = second.length_m / 2.0, second.width_m / 2.0
    return max(
        abs(dx_m * ahead_x + dy_m * ahead_y) - length1_m - (length2_m * along + width2_m * across),
        abs(dy_m * ahead_x - dx_m * ahead_y) - width1_m - (length2_m * across + width2_m * along),
        abs(dx_m * other_x + dy_m * other_y) - length2_m - (length1_m * along + width1_m * across),
        abs(dy_m * other_x - dx_m * other_y) - width2_m - (length1_m * across + width1_m * along),
    )


def standing(node: Node, heading_rad: float, length_m: float, width_m: float) -> Rectangle:
    """The area of a vehicle that stands on a node."""
    return Rectangle(node.x_m, node.y_m, heading_rad, length_m, width_m)


def driven(start: Node, end: Node, length_m: float, width_m: float) -> Rectangle:
    """The area that a vehicle covers on its drive from one node to another."""
    dx_m, dy_m = end.x_m - start.x_m, end.y_m - start.y_m
    return Rectangle(
        (start.x_m + end.x_m) / 2.0,
        (start.y_m + end.y_m) / 2.0,
        atan2(dy_m, dx_m),
        hypot(dx_m, dy_m) + length_m,
        width_m,
    )
