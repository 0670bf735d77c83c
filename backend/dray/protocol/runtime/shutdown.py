"""Graceful shutdown: from the request that an agent stop until its process ends (paper, 4.2 cases 2 and 6).

    HERE --Leaving--> DRAINING --nothing holds it, or its time is over--> gone (Leave)

It takes nothing new. What others can do as well it gives back, and waits until that was heard; what nobody
else can do it finishes. The rest is in its journal and in its body, for its next life. What is still open
when its time is over stays behind as after a crash, and is mended as after one.
"""

from __future__ import annotations

from dray.protocol.runtime.events import NEVER_S

"""What is told to whoever has to do without it, and stands in the history."""

CARRIER_LEAVES_WITHIN_S = 300.0
"""A vehicle with a load on board is at its end within this: the rest of a pick and the longest way of a
large plant, a dock that is held for as long as its machine allows, and the way back to a storage."""

COORDINATOR_LEAVES_WITHIN_S = 30.0
"""A round of bidding is over within this, and so is the transfer of a vehicle at the dock. Vehicles that
come to the dock later ask until its next life answers."""


class GracefulShutdown:
    """The graceful shutdown of one agent.

    Args:
        within_s: so long after it was asked it goes, whatever holds it.

    Attributes:
        begun: it was asked to leave.
        latest_s: when it goes at the latest; `NEVER_S` before it was asked, and when it has gone.
    """

    __slots__ = ("_within_s", "begun", "latest_s")

    def __init__(self, within_s: float) -> None:
        self._within_s = within_s
        self.begun = False
        self.latest_s = NEVER_S

    def start_draining(self, now_s: float) -> None:
        """The agent is asked to stop: from now on it drains."""
        self.begun = True
        self.latest_s = now_s + self._within_s

    @property
    def lasts(self) -> bool:
        """Whether the agent is draining: it was asked to stop and has not stopped."""
        return self.latest_s < NEVER_S

    def complete(self) -> None:
        """The agent stops: draining is over."""
        self.latest_s = NEVER_S
