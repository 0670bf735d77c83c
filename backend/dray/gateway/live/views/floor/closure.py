"""Closures by people, and their effect on lanes."""

from __future__ import annotations

from typing import Literal

from dray.gateway.live.views.base import View


class LaneView(View, kw_only=True):
    """A lane in one direction."""

    start: str
    end: str


class CornerView(View, kw_only=True):
    """A corner of an outline drawn on the floor."""

    x_m: float
    y_m: float


class ClosureView(View, kw_only=True):
    """A closure in force. One of lane, place, area and outline is set."""

    id: str
    kind: Literal["closed", "slow", "one_way"]
    lane: LaneView | None = None
    """Both directions; a one-way lane is driven from `start` to `end` only."""
    place: str = ""
    area: str = ""
    outline: tuple[CornerView, ...] = ()
    """Corners of a part of the floor, as drawn."""
    speed_mps: float | None = None
    """Speed limit for `slow`."""
    until_at_s: float | None = None
    """When it ends by itself; None if a person ends it."""
    reason: str
    by: str
    at_s: float
    lanes: tuple[LaneView, ...] = ()
    """Lanes that it closes or slows, each direction by itself."""
    not_known_by: tuple[str, ...] = ()
    """Vehicles that were heard and do not use it yet: out of reach or shut out."""
    cut_off: tuple[str, ...] = ()
    """Places without any way to or from them, with all closures together."""
