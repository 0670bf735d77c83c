"""What panels see of every agent, whatever else it is: its silence, its clock, whether it is on probation or shut out."""

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


class ClockView(View, kw_only=True):
    """How far an agent's clock is off, as its heartbeats show it; factory seconds."""

    ahead_s: float
    """Behind if below 0."""
    bound_s: float
    """It may be so much more or less: what the link takes and varies by."""
    wrong: bool
    """It is off by more than clocks of one plant are, beyond doubt."""


class ProbationView(View, kw_only=True):
    """How far an agent on probation has come: so many transports have to be done well."""

    of: int
    done: int = 0


class ShutOutView(View, kw_only=True):
    """A manager has shut the agent out: nobody hears it, whatever it says."""

    by: str
    """The name of who has decided it."""
    reason: str
    at_s: float
