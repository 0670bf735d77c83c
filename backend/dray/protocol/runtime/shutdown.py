"""Graceful shutdown: from the request to stop until the agent's process ends (paper, 4.2 cases 2 and 6).

    HERE --Leaving--> DRAINING --nothing holds it, or its time is over--> gone (Leave)

A draining agent takes no new work. It gives back what others can do, and waits for the acknowledgement. It finishes
what only it can do. The rest is in its journal and in its body, for its next life. Work that is open at the timeout
remains as after a crash, and is recovered like it.
"""

from __future__ import annotations

from dray.protocol.runtime.events import NEVER_S

"""Told to the agents that lose its service, and recorded in the history."""

CARRIER_LEAVES_WITHIN_S = 300.0
"""Time in which a vehicle with a load on board finishes (s): the rest of a pick, the longest way of a large plant, a dock
held as long as its machine allows, and the way back to a storage."""

COORDINATOR_LEAVES_WITHIN_S = 30.0
"""Time in which a bidding round ends, and a vehicle's transfer at the dock (s). Vehicles that come to the dock later repeat
their request until its next life answers."""


class GracefulShutdown:
    """The graceful shutdown of one agent.

    Args:
        within_s: maximum time from the request until it stops.

    Attributes:
        begun: whether it was asked to leave.
        latest_s: latest time of leaving; `NEVER_S` before the request, and after it has left.
    """

    __slots__ = ("_within_s", "begun", "latest_s")

    def __init__(self, within_s: float) -> None:
        self._within_s = within_s
        self.begun = False
        self.latest_s = NEVER_S

    def start_draining(self, now_s: float) -> None:
        """Start draining after the request to stop."""
        self.begun = True
        self.latest_s = now_s + self._within_s

    @property
    def lasts(self) -> bool:
        """Whether the agent is draining: it was asked to stop and has not stopped."""
        return self.latest_s < NEVER_S

    def complete(self) -> None:
        """Stop: draining is over."""
        self.latest_s = NEVER_S
