"""Plane geometry of the floor: points, polygons, circles and rectangles, in metres."""

from __future__ import annotations

from collections.abc import Sequence
from math import hypot

from dray.plant.model import Point


def cross(origin: Point, first: Point, second: Point) -> float:
    """Twice the area of a triangle in square metres: above 0 when it turns to the left."""
    ahead_x_m, ahead_y_m = first.x_m - origin.x_m, first.y_m - origin.y_m
    return ahead_x_m * (second.y_m - origin.y_m) - ahead_y_m * (second.x_m - origin.x_m)


def between(point: Point, start: Point, end: Point) -> bool:
    """Whether a point lies on the straight edge from `start` to `end`, ends included."""
    return (
        cross(start, end, point) == 0.0
        and min(start.x_m, end.x_m) <= point.x_m <= max(start.x_m, end.x_m)
        and min(start.y_m, end.y_m) <= point.y_m <= max(start.y_m, end.y_m)
    )


def edges(polygon: Sequence[Point]) -> list[tuple[Point, Point]]:
    """The edges of a polygon in order; the last one closes it."""
    return list(zip(polygon, (*polygon[1:], polygon[0]), strict=True))


def inside(point: Point, polygon: Sequence[Point]) -> bool:
    """Whether a point lies in a polygon; its border belongs to it, so neighbours share theirs."""
    odd = False
    for start, end in edges(polygon):
        if between(point, start, end):
            return True
        if (start.y_m > point.y_m) != (end.y_m > point.y_m):
            # The ray to the right meets the edge when the point lies on the edge's left, seen upwards.
            left = cross(start, end, point) > 0.0
            odd ^= left == (end.y_m > start.y_m)
    return odd


def box_of(polygon: Sequence[Point]) -> tuple[float, float, float, float]:
    """The box around a polygon: left, low, right, high (m)."""
    xs_m, ys_m = [corner.x_m for corner in polygon], [corner.y_m for corner in polygon]
    return min(xs_m), min(ys_m), max(xs_m), max(ys_m)


def distance_m(point: Point, polygon: Sequence[Point]) -> float:
    """Distance of a point outside of a polygon; 0 for one inside or on its border."""
    if inside(point, polygon):
        return 0.0
    return min(_distance_to_edge_m(point, start, end) for start, end in edges(polygon))


def _distance_to_edge_m(point: Point, start: Point, end: Point) -> float:
    along_x_m, along_y_m = end.x_m - start.x_m, end.y_m - start.y_m
    to_x_m, to_y_m = point.x_m - start.x_m, point.y_m - start.y_m
    length_m2 = along_x_m**2 + along_y_m**2
    # The foot of the perpendicular, as a part of the edge; one beyond its ends is the end itself.
    foot = (to_x_m * along_x_m + to_y_m * along_y_m) / length_m2 if length_m2 else 0.0
    foot = min(max(foot, 0.0), 1.0)
    return hypot(to_x_m - foot * along_x_m, to_y_m - foot * along_y_m)


def crossing(first: tuple[Point, Point], second: tuple[Point, Point]) -> bool:
    """Whether two straight edges have a point in common."""
    (a, b), (c, d) = first, second
    if any((between(c, a, b), between(d, a, b), between(a, c, d), between(b, c, d))):
        return True
    return (cross(a, b, c) > 0.0) != (cross(a, b, d) > 0.0) and (cross(c, d, a) > 0.0) != (
        cross(c, d, b) > 0.0
    )


def crossed_edges(polygon: Sequence[Point]) -> tuple[int, int] | None:
    """Two edges of a polygon that meet or overlap against the rules, by index; None where it is simple.

    Edge `i` begins at corner `i`. Neighbours share one corner and may not overlap otherwise.
    """
    sides = edges(polygon)
    for i, first in enumerate(sides):
        for j in range(i + 1, len(sides)):
            if j == i + 1 or (i == 0 and j == len(sides) - 1):
                a, shared, b = (
                    (first[0], first[1], sides[j][1]) if j == i + 1 else (sides[j][0], first[0], first[1])
                )
                if between(a, shared, b) or between(b, a, shared):
                    return i, j
            elif crossing(first, sides[j]):
                return i, j
    return None


def area_m2(polygon: Sequence[Point]) -> float:
    """The area of a simple polygon in square metres, whichever way round it is written."""
    return abs(sum(a.x_m * b.y_m - b.x_m * a.y_m for a, b in edges(polygon))) / 2.0
