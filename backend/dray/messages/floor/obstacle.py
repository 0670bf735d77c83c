"""Obstacles: things on a lane that are no vehicles, as vehicles see them and tell one another.

They are hints: a wrong one leads to a longer way for a while. A body stops before an obstacle in its way, with or without a hint.
"""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta

from dray.messages.base import Id, Message, Part
from dray.messages.kinds import GATEWAYS, VEHICLES

FORGOTTEN_S = 60.0
"""Time after which an obstacle that was seen once is forgotten, and a vehicle looks again."""

FORGOTTEN_AT_MOST_S = 600.0
"""Longest such time: it doubles each time that the obstacle is still there."""

MOST = 64
"""Maximum obstacles that count at one time; of one sender `MOST_OF_ONE`, so that none shuts a floor alone."""

MOST_OF_ONE = 8


class ObstacleSeen(Message, said_by=VEHICLES, signed="atv", frozen=True):
    """A vehicle has something in its way on a lane, or has driven where something was."""

    atv: Id
    start: Id
    end: Id
    """The nodes at the ends of the lane. Both directions are meant, where there are two."""
    there: bool
    """False when it is gone."""
    forget_in_s: Annotated[float, Meta(ge=0.0, le=FORGOTTEN_AT_MOST_S)] = 0.0
    """Time after which the obstacle does not count any more: the next vehicle looks again."""


class ObstacleCleared(Message, said_by=GATEWAYS, frozen=True):
    """A person says that a lane is free again."""

    start: Id
    end: Id
    by: Id


# --- what a body says to its agent (`dray.body`) -----------------------------------------------------


class WayBlocked(Part, frozen=True):
    """Something is in the body's way on a lane: it stands before the lane or brakes on it, and keeps its given way."""

    order: int
    start: str
    end: str
    entered: bool
    """Whether it is on the lane already, where it cannot turn round."""


class WayFree(Part, frozen=True):
    """The obstacle (`WayBlocked`) is gone: the body drives on by itself, if it was given no other way."""

    order: int
    start: str
    end: str
