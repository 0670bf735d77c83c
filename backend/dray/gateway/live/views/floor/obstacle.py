"""Obstacles on lanes, as vehicles report them."""

from __future__ import annotations

from dray.gateway.live.views.base import View


class ObstacleView(View, kw_only=True):
    """An obstacle on a lane; vehicles go round it."""

    id: str
    """Id of the lane: the nodes at its ends in alphabetical order, joined by `>`."""
    start: str
    end: str
    """Nodes at the ends of the lane, in the vehicle's direction."""
    by: str
    """The vehicle that saw it last."""
    at_s: float
    """When it was last seen."""
    until_at_s: float
    """When it is forgotten; the next vehicle looks again."""
