"""A guess of a vehicle's map frame from its positions at known nodes: a unit, an inverted axis, another origin."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import product
from math import hypot

from dray.plant.model import MapFrame

UNITS = (1.0, 0.001, 0.01)
"""Metres, millimetres, centimetres."""

Seen = tuple[float, float, float, float]
"""The reported x and y, and its node's position (m)."""


def fitting(seen: Iterable[Seen], frame: MapFrame, node_m: float) -> MapFrame | None:
    """A frame that puts the reported positions at the nodes, the simplest first; None where the present one does, or without data.

    Args:
        seen: one or more observations.
        frame: the present frame.
        node_m: maximum distance from a node.
    """
    pairs = list(seen)
    if not pairs or _off_m(pairs, frame) <= node_m:
        return None
    turned = [
        MapFrame(frame.id, frame.x_m, frame.y_m, heading, mirrored, unit)
        for unit, mirrored, heading in product(UNITS, (False, True), (0.0, 180.0, 90.0, -90.0))
    ]
    for candidate in turned:
        if _off_m(pairs, candidate) <= node_m:
            return candidate
    for candidate in turned:
        x_m, y_m, _ = MapFrame(
            "", 0.0, 0.0, candidate.heading_deg, candidate.mirrored, candidate.scale
        ).to_plant(*pairs[0][:2], 0.0)
        moved = MapFrame(
            frame.id,
            round(pairs[0][2] - x_m, 3),
            round(pairs[0][3] - y_m, 3),
            candidate.heading_deg,
            candidate.mirrored,
            candidate.scale,
        )
        if _off_m(pairs, moved) <= node_m:
            return moved
    return None


def described(frame: MapFrame) -> str:
    """A frame as a line of a profile: its differences from the plant's frame."""
    plain = MapFrame()
    said = [
        f"{name}: {str(value).lower() if isinstance(value, bool) else format(value, 'g')}"
        for name in ("x_m", "y_m", "heading_deg", "mirrored", "scale")
        if (value := getattr(frame, name)) != getattr(plain, name)
    ]
    return "map: {" + ", ".join([f'id: "{frame.id}"', *said]) + "}"


def _off_m(pairs: list[Seen], frame: MapFrame) -> float:
    """The largest distance between a position and its node."""
    off_m = 0.0
    for x, y, x_m, y_m in pairs:
        at_x_m, at_y_m, _ = frame.to_plant(x, y, 0.0)
        off_m = max(off_m, hypot(at_x_m - x_m, at_y_m - y_m))
    return off_m
