"""The guard of a listener: it limits the number of connections, and their waiting times.

A connection costs a file descriptor and memory before its user is known. So there are limits in total and for each address. At a
limit, a new connection replaces the oldest one without a request, so idle connections keep nobody out. A request that does not
arrive, or an answer that nobody reads, ends its connection.
"""

from __future__ import annotations

import asyncio
import resource
import time
from collections.abc import Callable, Iterable
from enum import Enum
from ipaddress import ip_address, ip_network
from typing import Any

from uvicorn.protocols.http.h11_impl import H11Protocol
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol

from dray.gateway.access.limits import neighbourhood

HEAD_S = 10.0
"""Wall seconds for the head of a request to arrive, from the connection or from the last answer: over the worst WLAN a
browser needs one."""

BODY_S = 20.0
"""Wall seconds for its body: 1 MiB at half a megabit per second."""

STALL_S = 30.0
"""Seconds without progress after which an answer is given up; a stream pings every 20 s."""

SPARE_FILES = 384
"""File descriptors reserved for other uses: 160 for stops, those of the database, the bus and served files, and some accepted
connections that are about to be refused."""


class Phase(Enum):
    """The phase of a connection."""

    HEAD = "head"
    """It waits for a request."""
    BODY = "body"
    ANSWER = "answer"
    """It sends an answer, or a stream."""


PATIENCE_S = {Phase.HEAD: HEAD_S, Phase.BODY: BODY_S}


class Visit:
    """One open connection.

    Args:
        transport: the connection.
        address: the other end's address or network; empty for unknown.
        protocol: its reader.
        now_s: a clock.
    """

    def __init__(self, transport: asyncio.Transport, address: str, protocol: Any, now_s: float) -> None:
        self.transport, self.address, self.protocol = transport, address, protocol
        self.taken_s = now_s
        """The time of the other end's last reading."""
        self._doing: tuple[Phase, object] = (Phase.HEAD, None)
        self._since_s = now_s

    @property
    def phase(self) -> Phase:
        """Its present phase."""
        return self._now()[0]

    def overdue(self, now_s: float) -> bool:
        """Whether its phase lasts too long."""
        if not self.transport.get_write_buffer_size():
            self.taken_s = now_s
        doing = self._now()
        if doing != self._doing:
            self._doing, self._since_s = doing, now_s
        patience_s = PATIENCE_S.get(doing[0])
        if patience_s is not None and now_s - self._since_s > patience_s:
            return True
        return now_s - self.taken_s > STALL_S

    def _now(self) -> tuple[Phase, object]:
        if not isinstance(self.protocol, H11Protocol):
            return Phase.ANSWER, None
        cycle: Any = self.protocol.cycle
        if cycle is None or cycle.response_complete:
            return Phase.HEAD, cycle
        return (Phase.BODY if cycle.more_body else Phase.ANSWER), cycle


class Guard:
    """The connections of one listener.

    Args:
        most: maximum connections in total.
        each: maximum connections per address.
        exempt: addresses or networks without that maximum, which speak for many.
        now_s: a monotonic clock.

    Attributes:
        turned_away: connections ended because of a limit.
        given_up: connections ended because of a timeout.
    """

    def __init__(
        self, *, most: int, each: int, exempt: Iterable[str] = (), now_s: Callable[[], float] = time.monotonic
    ) -> None:
        self._most, self._each, self._now_s = most, each, now_s
        self._exempt = tuple(ip_network(each) for each in exempt)
        self._visits: dict[asyncio.BaseTransport, Visit] = {}
        """By transport, the oldest first."""
        self._of: dict[str, dict[asyncio.BaseTransport, Visit]] = {}
        """The same by address."""
        self.turned_away = 0
        self.given_up = 0

    @property
    def connected(self) -> int:
        """Number of connections."""
        return len(self._visits)

    def enter(self, transport: asyncio.Transport, protocol: Any) -> None:
        """A new connection, or another protocol of an open one."""
        known = self._visits.get(transport)
        if known is not None:
            known.protocol = protocol
            return
        peer = transport.get_extra_info("peername")
        address = str(peer[0]) if isinstance(peer, tuple) and peer else ""
        address = "" if self._exempted(address) else neighbourhood(address)
        visit = Visit(transport, address, protocol, self._now_s())
        others = self._of.get(address, {})
        if (address and len(others) >= self._each and not self._make_room(others.values())) or (
            len(self._visits) >= self._most and not self._make_room(self._visits.values())
        ):
            self._turn_away(visit)
        else:
            self._visits[transport] = visit
            self._of.setdefault(address, {})[transport] = visit

    def _exempted(self, address: str) -> bool:
        if not self._exempt or not address:
            return False
        try:
            parsed = ip_address(address.partition("%")[0])
        except ValueError:
            return False
        return any(parsed in network for network in self._exempt)

    def leave(self, transport: asyncio.BaseTransport) -> None:
        """A connection has ended; harmless when repeated."""
        visit = self._visits.pop(transport, None)
        if visit is None:
            return
        same = self._of[visit.address]
        del same[transport]
        if not same:
            del self._of[visit.address]

    def flows(self, transport: asyncio.BaseTransport) -> None:
        """The other end has read data."""
        visit = self._visits.get(transport)
        if visit is not None:
            visit.taken_s = self._now_s()

    def sweep(self) -> None:
        """End the connections whose phase lasts too long."""
        now_s = self._now_s()
        for visit in [visit for visit in self._visits.values() if visit.overdue(now_s)]:
            self.given_up += 1
            self._end(visit)

    def _make_room(self, visits: Iterable[Visit]) -> bool:
        """End the oldest waiting one of these connections, preferably one without a request; False when there is none."""
        for phase in (Phase.HEAD, Phase.BODY):
            waiting = next((visit for visit in visits if visit.phase is phase), None)
            if waiting is not None:
                self._turn_away(waiting)
                return True
        return False

    def _turn_away(self, visit: Visit) -> None:
        self.turned_away += 1
        self._end(visit)

    def _end(self, visit: Visit) -> None:
        self.leave(visit.transport)
        visit.transport.abort()


def guarded(guard: Guard) -> tuple[type[asyncio.Protocol], type[asyncio.Protocol]]:
    """The protocols of uvicorn for HTTP and websockets, watched over by a guard."""

    class Http(H11Protocol):
        def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
            super().connection_made(transport)
            guard.enter(transport, self)

        def connection_lost(self, exc: Exception | None) -> None:
            guard.leave(self.transport)
            super().connection_lost(exc)

        def resume_writing(self) -> None:
            guard.flows(self.transport)
            super().resume_writing()

    class Socket(WebSocketsSansIOProtocol):
        def connection_made(self, transport: asyncio.BaseTransport) -> None:
            super().connection_made(transport)
            assert isinstance(transport, asyncio.Transport)  # noqa: S101 - a socket's
            guard.enter(transport, self)

        def connection_lost(self, exc: Exception | None) -> None:
            guard.leave(self.transport)
            super().connection_lost(exc)

        def resume_writing(self) -> None:
            guard.flows(self.transport)
            super().resume_writing()

    return Http, Socket


def room_for(connections: int) -> int:
    """The possible number of connections that leaves `SPARE_FILES`; raises the process's own limit for it.

    Args:
        connections: the wanted number.
    """
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    wanted = connections + SPARE_FILES
    if soft == resource.RLIM_INFINITY or soft >= wanted:
        return connections
    raised = wanted if hard == resource.RLIM_INFINITY else min(hard, wanted)
    resource.setrlimit(resource.RLIMIT_NOFILE, (raised, hard))
    return max(raised - SPARE_FILES, 16)
