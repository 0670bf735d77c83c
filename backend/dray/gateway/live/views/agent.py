"""What panels see of every agent: its silence, its clock, probation and exclusion."""

from __future__ import annotations

from dray.gateway.live.views.base import View


class SilenceView(View, kw_only=True):
    """How long an agent may be silent, by the agents' own rule; factory seconds after its last heartbeat."""

    beat_s: float
    """When the next heartbeat is sent."""
    overdue_after_s: float
    """When a heartbeat is overdue: nothing to act on, but worth a look."""
    lost_after_s: float
    """When the agent counts as failed."""


class ClockView(View, kw_only=True):
    """The offset of an agent's clock, by its heartbeats; factory seconds."""

    ahead_s: float
    """Seconds ahead; negative if behind."""
    bound_s: float
    """Uncertainty of `ahead_s`: the link's delay and its jitter."""
    wrong: bool
    """Whether the offset certainly exceeds what is normal in one plant."""


class ProbationView(View, kw_only=True):
    """Progress of an agent on probation: transports done well, of those required."""

    of: int
    done: int = 0


class ShutOutView(View, kw_only=True):
    """A manager has shut the agent out: its messages are ignored."""

    by: str
    """Name of the manager."""
    reason: str
    at_s: float
