"""The terms of a task that is put up for auction."""

from __future__ import annotations

import msgspec

from dray.messages import Role, Work

SPAN_MIN_S = 60.0
"""Minimum time for an overdue task (s), about a quick transport; it grows each round."""

SPAN_MAX_S = 7 * 86_400.0
"""Maximum time of a task (s). A longer deadline attracts no more bids, and must not move beyond the message's range."""

SPANS_MAX = 10
"""Maximum factor of the time span: after so many rounds the deadline is not what keeps bidders away."""


class Terms(msgspec.Struct, frozen=True):
    """The terms of a task that is put up for auction."""

    task: str
    epoch: int
    role: Role
    work: Work
    deadline_s: float
    primary: str = ""
    """The primary to watch, if the role is SECONDARY."""

    def span_s(self, now_s: float) -> float:
        """Time for a bidder that begins now (s)."""
        return min(max(self.deadline_s - now_s, SPAN_MIN_S), SPAN_MAX_S)

    def until(self, deadline_s: float) -> Terms:
        """The terms with a later deadline; an earlier one changes nothing."""
        return msgspec.structs.replace(self, deadline_s=max(deadline_s, self.deadline_s))


class Place(msgspec.Struct, frozen=True):
    """Where the coordinator stands, and how far its plant reaches."""

    x_m: float
    y_m: float
    reach_m: float
    """The radius beyond which there is no agent."""
