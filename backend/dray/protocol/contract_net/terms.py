"""What is put up for auction, and from where."""

from __future__ import annotations

import msgspec

from dray.messages import Role, Work

SPAN_MIN_S = 60.0
"""What is late already is given as much time as a quick transport takes, round after round more."""

SPAN_MAX_S = 7 * 86_400.0
"""What has weeks is not refused for its deadline. One that is years away must not move beyond what can be said."""

SPANS_MAX = 10
"""After so many rounds it is not the deadline that keeps bidders away."""


class Terms(msgspec.Struct, frozen=True):
    """What is put up for auction."""

    task: str
    epoch: int
    role: Role
    work: Work
    deadline_s: float
    primary: str = ""
    """Whom to watch, when the role is SECONDARY."""

    def span_s(self, now_s: float) -> float:
        """How much time a bidder has that begins now."""
        return min(max(self.deadline_s - now_s, SPAN_MIN_S), SPAN_MAX_S)

    def until(self, deadline_s: float) -> Terms:
        """The same with a later deadline; an earlier one changes nothing."""
        return msgspec.structs.replace(self, deadline_s=max(deadline_s, self.deadline_s))


class Place(msgspec.Struct, frozen=True):
    """Where the coordinator stands, and how far its plant reaches."""

    x_m: float
    y_m: float
    reach_m: float
    """The radius beyond which there is nobody."""
