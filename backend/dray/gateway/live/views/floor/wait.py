"""Waits: which vehicle waits for which, and why."""

from __future__ import annotations

from typing import Literal

from dray.gateway.live.views.base import View

WaitKind = Literal[
    "docked",
    "charging",
    "silent",
    "stopped",
    "error",
    "closed",
    "circle",
    "standing",
    "moving",
    "unanswered",
]
"""What blocks the last vehicle of a chain. It is at a dock with a task; charges; is silent; was stopped by a
person; is in error; has no way left by closures; waits in a circle; stands and was asked to make room;
drives; or makes room itself, or has no answer yet."""


class WaitCauseView(View, kw_only=True):
    """The vehicles that a vehicle waits for, and what blocks the last of them."""

    kind: WaitKind
    chain: tuple[str, ...] = ()
    """The vehicle waited for, the one that that waits for, and so on. In a circle, the last waits for one
    named before or for the vehicle itself."""
    more: int = 0
    """Number of vehicles that a long chain leaves out before its last."""
    place: str = ""
    """For one that is docked, charges or stands: the place of that dock."""
    since_at_s: float | None = None
    """Time since which the last one stands like this; None for one that drives, and for a circle."""


class WaitView(View, kw_only=True):
    """A vehicle that cannot drive on, because it waits for a place or makes room."""

    id: str
    """Id of the vehicle."""
    since_at_s: float
    """Time since which it has stood there."""
    place: str = ""
    """The node or crossing that it needs and another vehicle holds; empty if unknown."""
    cause: WaitCauseView
    text: str = ""
    """The cause in English."""
