"""Who waits for whom to drive on, and why."""

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
"""What holds up the one at the end of a chain: it is at a dock with a task; charges; is not heard; was stopped by a person; is in error; has no way left by
what is closed; waits for one that waits for it; stands, and is asked to make room; drives; makes room itself, or has no answer yet."""


class WaitCauseView(View, kw_only=True):
    """For whom a vehicle waits, and what holds up the one at the end of the chain."""

    kind: WaitKind
    chain: tuple[str, ...] = ()
    """Whom it waits for, whom that one waits for, and so on. In a circle the last one waits for one that was named before, or for
    the vehicle itself."""
    more: int = 0
    """How many a long chain leaves out, before its last one."""
    place: str = ""
    """For one that is docked, charges or stands: whose dock it is at."""
    since_at_s: float | None = None
    """Since when the last one stands as it does; None for one that drives, and for a circle."""


class WaitView(View, kw_only=True):
    """A vehicle that cannot drive on, because it waits for a place or makes room."""

    id: str
    """The vehicle's."""
    since_at_s: float
    """Since when it has stood where it stands."""
    place: str = ""
    """The node or crossing that it needs and another one has; empty where it does not know."""
    cause: WaitCauseView
    text: str = ""
    """The same in English."""
