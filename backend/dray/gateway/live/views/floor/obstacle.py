"""What lies on lanes, as vehicles have told."""

from __future__ import annotations

from dray.gateway.live.views.base import View


class ObstacleView(View, kw_only=True):
    """Something that was seen on a lane; vehicles go round it."""

    id: str
    """Of the lane: the nodes at its ends, in the order of the alphabet, with a `>` between."""
    start: str
    end: str
    """The nodes at the ends of the lane, as the vehicle meant to drive it."""
    by: str
    """The vehicle that has seen it last."""
    at_s: float
    """When that was."""
    until_at_s: float
    """Then it is forgotten, and whoever comes there looks again."""
