"""The silence of an agent as panels see it."""

from __future__ import annotations

from dray.gateway.live.views.base import View


class SilenceView(View, kw_only=True):
    """How long an agent may say nothing, by the rule of the agents themselves; factory seconds after its last heartbeat."""

    beat_s: float
    """Then the next one is said."""
    overdue_after_s: float
    """Then it should have come: nothing to act on, but something to look at."""
    lost_after_s: float
    """Then the agent counts as failed."""
