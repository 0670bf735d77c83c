"""Obstacles: what stands or lies on a lane and is no vehicle, as vehicles see it and tell one another.

A hint and no right: who believes a wrong one takes a longer way for a while. A body stops before what is in its way, whatever
was told.
"""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta

from dray.messages.base import Id, Message, Part
from dray.messages.kinds import GATEWAYS, VEHICLES

FORGOTTEN_S = 60.0
"""An obstacle that was seen once is forgotten after this, and somebody looks again."""

FORGOTTEN_AT_MOST_S = 600.0
"""That doubles each time that it is still there, up to this."""

MOST = 64
"""Obstacles that are counted on at one time; of one speaker `MOST_OF_ONE`, so that nobody shuts a floor alone."""

MOST_OF_ONE = 8


class ObstacleSeen(Message, said_by=VEHICLES, signed="atv", frozen=True):
    """A vehicle has something in its way on a lane, or has driven where something was."""

    atv: Id
    start: Id
    end: Id
    """The nodes at the ends of the lane. Both directions are meant, where there are two."""
    there: bool
    """False: it is gone."""
    forget_in_s: Annotated[float, Meta(ge=0.0, le=FORGOTTEN_AT_MOST_S)] = 0.0
    """From then on nobody counts on it: whoever comes there looks again."""


class ObstacleCleared(Message, said_by=GATEWAYS, frozen=True):
    """A person says that a lane is free again."""

    start: Id
    end: Id
    by: Id


# --- what a body says to its agent (`dray.body`) -----------------------------------------------------


class WayBlocked(Part, frozen=True):
    """Something is in its way on a lane: it stands before the lane, or brakes on it, and leaves its way as it was given."""

    order: int
    start: str
    end: str
    entered: bool
    """It is on the lane already, and cannot turn round there."""


class WayFree(Part, frozen=True):
    """What it has stopped for (`WayBlocked`) is gone: it drives on by itself, if it was given no other way."""

    order: int
    start: str
    end: str
