"""What people have closed to vehicles, and what that means for the lanes."""

from __future__ import annotations

from typing import Literal

from dray.gateway.live.views.base import View


class LaneView(View, kw_only=True):
    """A lane in one direction."""

    start: str
    end: str


class CornerView(View, kw_only=True):
    """A corner of what somebody has drawn on the floor."""

    x_m: float
    y_m: float


class ClosureView(View, kw_only=True):
    """A closure that holds. Of lane, place, area and outline one is named."""

    id: str
    kind: Literal["closed", "slow", "one_way"]
    lane: LaneView | None = None
    """Both directions of it, unless it became one-way: then it is driven from `start` to `end` only."""
    place: str = ""
    area: str = ""
    outline: tuple[CornerView, ...] = ()
    """The corners of a part of the floor, as somebody has drawn it."""
    speed_mps: float | None = None
    """For `slow`: the highest speed there."""
    until_at_s: float | None = None
    """When it ends by itself; None for when somebody ends it."""
    reason: str
    by: str
    at_s: float
    lanes: tuple[LaneView, ...] = ()
    """The lanes that it closes or makes slow, each direction by itself."""
    not_known_by: tuple[str, ...] = ()
    """Vehicles that were heard and do not go by it yet: they are out of reach, or shut out."""
    cut_off: tuple[str, ...] = ()
    """Places to and from which no way is left, with all closures together."""
