"""A vehicle's modem: it has WLAN and a radio, uses the one that it believes in, and says when that changes.

Nothing ticks. Whether the WLAN is really there is asked when the vehicle says something, which every
vehicle does at least every five seconds, and when a fault begins or ends. The modem believes it only
when it has been so for `NOTICE_S`: until then the vehicle talks into the void.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from dray.messages import Link

if TYPE_CHECKING:
    from dray.messages import Pose

NOTICE_S = 1.0
"""From the loss or the return of the WLAN until the modem says so: some lost beacons of an access
point (one in 102 ms) and a few tries to reach another, or the time to join again."""


class Modem:
    """One vehicle's modem.

    Args:
        agent: the vehicle.
        where: its pose at this moment.
        notice: told when the link has changed.

    Attributes:
        link: what the modem uses at present.
        pending: it has seen another state and waits whether that lasts.
        gateway: who last passed a frame of this vehicle on to the bus; empty for nobody.
        gateway_s: when that was.
        tokens: frames that it may send at once, as of `tokens_s`.
    """

    __slots__ = (
        "_at_s",
        "_position_m",
        "_where",
        "agent",
        "gateway",
        "gateway_s",
        "link",
        "notice",
        "pending",
        "tokens",
        "tokens_s",
    )

    def __init__(self, agent: str, where: Callable[[], Pose], notice: Callable[[Link], None]) -> None:
        self.agent = agent
        self.notice = notice
        self.link = Link.WLAN
        self.pending = False
        self.gateway = ""
        self.gateway_s = 0.0
        self.tokens = float("inf")
        self.tokens_s = 0.0
        self._where = where
        self._at_s = -1.0
        self._position_m = (0.0, 0.0)

    def position_m(self, now_s: float) -> tuple[float, float]:
        """Where it is, as (x_m, y_m); asked of the vehicle once in every instant."""
        if self._at_s != now_s:
            pose = self._where()
            self._at_s, self._position_m = now_s, (pose.x_m, pose.y_m)
        return self._position_m

    def turn_to(self, link: Link) -> None:
        """Use this link from now on, and say so."""
        self.link = link
        self.notice(link)
