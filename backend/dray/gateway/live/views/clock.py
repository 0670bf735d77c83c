"""The clock of an agent as panels see it."""

from __future__ import annotations

from dray.gateway.live.views.base import View


class ClockView(View, kw_only=True):
    """How far an agent's clock is off, as its heartbeats show it; factory seconds."""

    ahead_s: float
    """Behind if below 0."""
    bound_s: float
    """It may be so much more or less: what the link takes and varies by."""
    wrong: bool
    """It is off by more than clocks of one plant are, beyond doubt."""
