"""A vehicle's modem on a real network: it tells whether the vehicle is on the WLAN, or on its neighbours' radio only.

Zenoh bypasses a lost link silently. A vehicle must know of it: without WLAN it keeps its task and takes no other. So the modem adds
the state of the links to the body's state.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from ipaddress import IPv4Address, IPv4Network, IPv6Address, IPv6Network, ip_address

import msgspec
import zenoh
from zenoh.handlers import Callback

from dray.adapters.crossing import Crossing
from dray.body import BodyState, Instruction, LinkNoticed, Report, VehicleState
from dray.messages import Link
from dray.ports import Body

Network = IPv4Network | IPv6Network

SETTLE_S = 0.25
"""Delay between a change of links and its report. Zenoh chooses new paths after 0.1 s. Messages before that are lost on the old
path, including the heartbeat about the change."""


class Modem:
    """A vehicle's body that also senses its links (see `dray.ports.Body`).

    Any link that is not on the radio is WLAN, and an open one means that the vehicle is on it. A link is open until it has been
    silent for a lease.

    Args:
        body: the vehicle's other senses and instructions.
        session: the session of the links.
        radio: the networks of the vehicles' own radio.
    """

    def __init__(self, body: Body, session: zenoh.Session, radio: tuple[Network, ...]) -> None:
        self._body, self._session, self._radio = body, session, radio
        self._report: Callable[[Report], None] | None = None
        self._loop = asyncio.get_running_loop()
        self._crossing = Crossing(self._loop)
        self._listener = session.info.declare_link_events_listener(Callback(self._see, indirect=False))
        self._link = self._look()

    def instruct(self, instruction: Instruction) -> None:
        """See `dray.ports.Body`."""
        self._body.instruct(instruction)

    def sense(self) -> BodyState:
        """See `dray.ports.Body`."""
        state = self._body.sense()
        if isinstance(state, VehicleState) and state.link is not self._link:
            return msgspec.structs.replace(state, link=self._link)
        return state

    def attach(self, report: Callable[[Report], None]) -> None:
        """See `dray.ports.Body`."""
        self._report = report
        self._body.attach(report)

    def _look(self) -> Link:
        on_wlan = any(not self._is_radio(link) for link in self._session.info.links())
        return Link.WLAN if on_wlan else Link.MESH

    def _is_radio(self, link: zenoh.Link) -> bool:
        address = address_of(link.src)
        return any(address in network for network in self._radio)

    def _notice(self) -> None:
        # Closing all links is leaving.
        if self._session.is_closed() or (link := self._look()) is self._link:
            return
        self._link = link
        if self._report is not None:
            self._report(LinkNoticed(link=link))

    # --- on Zenoh's threads ----------------------------------------------------------------------

    def _see(self, _event: zenoh.LinkEvent) -> None:
        # A full queue loses nothing: the waiting events check all links later.
        self._crossing.offer(self._loop.call_later, SETTLE_S, self._notice)


def address_of(locator: str) -> IPv4Address | IPv6Address:
    """The address in a Zenoh locator, as ``tls/10.8.0.3:40112`` or ``tls/[fd00::3]:40112``."""
    host = locator.partition("/")[2].rpartition(":")[0]
    return ip_address(host.strip("[]"))
