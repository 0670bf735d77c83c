"""Curves as corners: NURBS of LIF, Bezier curves of openTCS.

A curve becomes a chain of straight pieces. The chain deviates by at most `TOLERANCE_M` and bends by at most
`BEND_RAD` at a corner. So its length is right to a few thousandths, and no corner counts as a turn
(`dray.plant.roads.BEND_RAD`).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise
from math import atan2, hypot, pi, radians

TOLERANCE_M = 0.02
"""Largest deviation: that of a vehicle from its lane."""

BEND_RAD = radians(20.0)

SHORT_M = 0.05
"""Shorter pieces are not divided: a curve with a cusp has no smooth corners."""

MAX_CORNERS = 200
"""Most corners of one lane, as in the plant file."""

DEEPEST = 9
"""Halvings of one span: 512 pieces."""

MAX_DEGREE = 10
LIGHT = 1e-9
"""The least weight of a control point; a lighter one takes no part in a curve."""

FAR_M = 1e6
"""Largest distance from the origin: no plant is larger, and products of such lengths can be computed."""

MAX_POINTS = 1_000
"""Most control points of one curve; a track has fewer."""

Spot = tuple[float, float]
Curve = Callable[[float], Spot]


class CurveError(ValueError):
    """An invalid curve; the text says why."""


def nurbs(degree: int, knots: Sequence[float], points: Sequence[tuple[float, float, float]]) -> list[Spot]:
    """A NURBS as corners, both ends included.

    Args:
        degree: at least 1.
        knots: as many as points + degree + 1, never falling.
        points: x, y and weight of the control points.

    Raises:
        CurveError: these are no NURBS.
    """
    if not 1 <= degree <= MAX_DEGREE:
        raise CurveError(f"a degree of {degree} is not within 1 to {MAX_DEGREE}")
    if not degree < len(points) <= MAX_POINTS:
        raise CurveError(f"{len(points)} control points do not make a curve of degree {degree}")
    if len(knots) != len(points) + degree + 1:
        raise CurveError(f"{len(knots)} knots where {len(points) + degree + 1} are needed")
    if any(after < before for before, after in pairwise(knots)):
        raise CurveError("the knots fall")
    if not all(abs(value) <= FAR_M for point in points for value in point) or any(
        weight < LIGHT for *_, weight in points
    ):
        raise CurveError(
            f"a control point lies further than {FAR_M / 1000:g} km away or has no weight above 0"
        )
    if degree == 1 and all(weight == points[0][2] for *_, weight in points):
        return [(x_m, y_m) for x_m, y_m, _ in points]
    spans = sorted(set(knots[degree : len(points) + 1]))
    if len(spans) < 2:
        raise CurveError("all knots are alike")

    def at(t: float) -> Spot:
        return _de_boor(degree, knots, points, t)

    return _flat(at, spans)


def bezier(points: Sequence[Spot]) -> list[Spot]:
    """A Bezier curve of any degree as corners, both ends included.

    Raises:
        CurveError: a control point lies too far away.
    """
    if not all(abs(value) <= FAR_M for point in points for value in point):
        raise CurveError(f"a control point lies further than {FAR_M / 1000:g} km away")

    def at(t: float) -> Spot:
        row = list(points)
        while len(row) > 1:
            row = [(a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])) for a, b in pairwise(row)]
        return row[0]

    return _flat(at, [0.0, 0.5, 1.0])


def length_m(corners: Sequence[Spot]) -> float:
    """Length of a chain of straight pieces."""
    return sum(hypot(b[0] - a[0], b[1] - a[1]) for a, b in pairwise(corners))


def is_straight(corners: Sequence[Spot], tolerance_m: float = 0.001) -> bool:
    """Whether a chain is one straight line from its first to its last corner."""
    return all(_off_m(spot, corners[0], corners[-1]) <= tolerance_m for spot in corners[1:-1])


def apart_m(corners: Sequence[Spot], chain: Sequence[Spot]) -> float:
    """Largest distance of one chain's corners from the pieces of another one; a single corner is its own piece."""
    pieces = list(pairwise(chain)) or [(chain[0], chain[0])]
    return max(min(_off_m(spot, *piece) for piece in pieces) for spot in corners)


def _flat(curve: Curve, spans: Sequence[float]) -> list[Spot]:
    tolerance_m = TOLERANCE_M
    while True:
        corners = [curve(spans[0])]
        for before, after in pairwise(spans):
            _divide(curve, before, after, corners, tolerance_m, DEEPEST)
        if len(corners) <= MAX_CORNERS:
            return corners
        tolerance_m *= 2.0
        if tolerance_m > 1.0:
            raise CurveError(f"it needs more than {MAX_CORNERS} corners")


def _divide(
    curve: Curve, begin: float, end: float, corners: list[Spot], tolerance_m: float, deeper: int
) -> None:
    """Add the corners from one parameter to another, the first one excluded."""
    start, stop = curve(begin), curve(end)
    parts = [curve(begin + (end - begin) * part) for part in (0.25, 0.5, 0.75)]
    chain = [start, *parts, stop]
    smooth = all(_off_m(spot, start, stop) <= tolerance_m for spot in parts) and (
        length_m(chain) <= SHORT_M or tolerance_m > TOLERANCE_M or _bend_rad(chain) <= BEND_RAD
    )
    if smooth or deeper == 0:
        corners.append(stop)
    else:
        middle = (begin + end) / 2.0
        _divide(curve, begin, middle, corners, tolerance_m, deeper - 1)
        _divide(curve, middle, end, corners, tolerance_m, deeper - 1)


def _bend_rad(chain: Sequence[Spot]) -> float:
    """Between the first and the last piece of a chain."""
    headings = [
        atan2(b[1] - a[1], b[0] - a[0]) for a, b in pairwise(chain) if hypot(b[0] - a[0], b[1] - a[1]) > 1e-9
    ]
    if len(headings) < 2:
        return 0.0
    turn = abs(headings[-1] - headings[0]) % (2.0 * pi)
    return min(turn, 2.0 * pi - turn)


def _off_m(spot: Spot, start: Spot, end: Spot) -> float:
    """Distance from a spot to the straight piece between two others."""
    along_x, along_y = end[0] - start[0], end[1] - start[1]
    to_x, to_y = spot[0] - start[0], spot[1] - start[1]
    square = along_x**2 + along_y**2
    part = min(max((to_x * along_x + to_y * along_y) / square, 0.0), 1.0) if square else 0.0
    return hypot(to_x - part * along_x, to_y - part * along_y)


def _de_boor(
    degree: int, knots: Sequence[float], points: Sequence[tuple[float, float, float]], t: float
) -> Spot:
    """The point of a NURBS at a parameter (de Boor's algorithm on homogeneous coordinates)."""
    span = degree
    while span < len(points) - 1 and t >= knots[span + 1]:
        span += 1
    rows = [(x * w, y * w, w) for x, y, w in (points[index] for index in range(span - degree, span + 1))]
    for level in range(1, degree + 1):
        for index in range(degree, level - 1, -1):
            low, high = knots[index + span - degree], knots[index + 1 + span - level]
            part = (t - low) / (high - low) if high > low else 0.0
            before, here = rows[index - 1], rows[index]
            rows[index] = (
                before[0] + part * (here[0] - before[0]),
                before[1] + part * (here[1] - before[1]),
                before[2] + part * (here[2] - before[2]),
            )
    x, y, w = rows[degree]
    return x / w, y / w
