"""Vehicles' modems: each has WLAN and a radio, uses the one that it believes in, and says when that changes.

Nothing ticks. The modem checks the WLAN when the vehicle sends a message, which every vehicle does at least every
five seconds, and when a fault begins or ends. The modem believes it only when it has been so for `NOTICE_S`: until
then the vehicle talks into the void.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from dray.messages import Link

if TYPE_CHECKING:
    from dray.messages import Pose
    from dray_sim.clock.loop import VirtualClock
    from dray_sim.network.links import Links

NOTICE_S = 1.0
"""Time from the loss or the return of the WLAN until the modem reports it. It covers some lost beacons of an access
point (one in 102 ms) and a few tries to reach another, or the time to join again."""


Notice = Callable[["Link", str], None]
"""The vehicle's new link, and the access point that served it when it lost the WLAN."""


class Modem:
    """One vehicle's modem.

    Args:
        agent: the vehicle.
        where: its pose at this moment.
        notice: told when the link has changed; see `Notice`.

    Attributes:
        link: in use at present.
        access_point: that served it when it lost the WLAN; empty for none that is known.
        pending: it has seen another state and waits until that has lasted.
        gateway: the last vehicle that relayed a frame of this one to the bus; empty for none.
        gateway_s: when that was.
        tokens: frames that it may send at once, as of `tokens_s`.
    """

    __slots__ = (
        "_at_s",
        "_position_m",
        "_where",
        "access_point",
        "agent",
        "gateway",
        "gateway_s",
        "link",
        "notice",
        "pending",
        "tokens",
        "tokens_s",
    )

    def __init__(self, agent: str, where: Callable[[], Pose], notice: Notice) -> None:
        self.agent = agent
        self.notice = notice
        self.link = Link.WLAN
        self.access_point = ""
        self.pending = False
        self.gateway = ""
        self.gateway_s = 0.0
        self.tokens = float("inf")
        self.tokens_s = 0.0
        self._where = where
        self._at_s = -1.0
        self._position_m = (0.0, 0.0)

    def position_m(self, now_s: float) -> tuple[float, float]:
        """Its position as (x_m, y_m); the vehicle is asked once in every instant."""
        if self._at_s != now_s:
            pose = self._where()
            self._at_s, self._position_m = now_s, (pose.x_m, pose.y_m)
        return self._position_m

    def turn_to(self, link: Link) -> None:
        """Use this link from now on, and say so."""
        self.link = link
        self.notice(link, self.access_point if link is Link.MESH else "")


class Modems:
    """All modems of a network, and the agents that the WLAN reaches. An agent without a modem is wired.

    Args:
        clock: calls back when a state has lasted long enough.
        links: the faults.

    Attributes:
        stations: the modems by vehicle, in the order in which they came.
        busy: whether any agent could be without WLAN, or any link in trouble; while it is False, no check is needed.
    """

    def __init__(self, clock: VirtualClock, links: Links) -> None:
        self.stations: dict[str, Modem] = {}
        self.busy = not links.quiet
        self._clock = clock
        self._links = links

    def equip(self, modem: Modem) -> None:
        """Add a vehicle's modem, or replace it."""
        self.stations[modem.agent] = modem
        if self.busy:
            self._look(modem)

    def has_wlan(self, agent: str) -> bool:
        """Whether the WLAN reaches an agent now, independently of its modem."""
        links = self._links
        if agent in links.wlan_cut:
            return False
        if links.coverage.perfect:
            return True
        modem = self.stations.get(agent)
        return modem is None or links.coverage.covers(*modem.position_m(self._clock.time_s))

    def talks_wlan(self, agent: str) -> bool:
        """Whether a message of an agent goes out by WLAN now: it is there, and its modem uses it."""
        modem = self.stations.get(agent)
        if modem is None:
            return self.has_wlan(agent)
        return self._look(modem) and modem.link is Link.WLAN

    def look_around(self) -> None:
        """Something has begun or ended: every modem looks, also that of a vehicle that says nothing."""
        for modem in self.stations.values():
            self._look(modem)
        self._take_stock()

    def _look(self, modem: Modem) -> bool:
        """Let a modem see whether it has WLAN; a change must last before it believes it."""
        has_wlan = self.has_wlan(modem.agent)
        if has_wlan is not (modem.link is Link.WLAN) and not modem.pending:
            modem.pending = True
            if not has_wlan:
                modem.access_point = self._links.coverage.nearest(*modem.position_m(self._clock.time_s))
            self._clock.call_at(self._clock.time_s + NOTICE_S, self._notice, modem)
        return has_wlan

    def _notice(self, modem: Modem) -> None:
        modem.pending = False
        link = Link.WLAN if self.has_wlan(modem.agent) else Link.MESH
        if link is not modem.link and self.stations.get(modem.agent) is modem:
            modem.turn_to(link)
        self._take_stock()

    def _take_stock(self) -> None:
        """See whether all is well again: nothing is wrong, and every modem has noticed."""
        unsettled = any(modem.pending or modem.link is Link.MESH for modem in self.stations.values())
        self.busy = unsettled or not self._links.quiet
