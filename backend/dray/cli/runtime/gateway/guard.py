"""The guard of a listener: how many may be connected, and how long they may keep us waiting.

A connection costs a file descriptor and memory before anybody has said who is there. So there are bounds: in all,
and for each address. Who comes to a bound takes the place of whoever has been connected longest without having asked for
anything, so a crowd that only holds connections keeps nobody out. A request that does not arrive, or an answer that
nobody reads, ends its connection.
"""

from __future__ import annotations

import asyncio
import resource
import time
from collections.abc import Callable, Iterable
from enum import Enum
from typing import Any

from uvicorn.protocols.http.h11_impl import H11Protocol
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol

from dray.gateway.access.limits import neighbourhood

HEAD_S = 10.0
"""Wall seconds for the head of a request to arrive, from the connection or from the answer before it: over the worst
WLAN a browser needs one."""

BODY_S = 20.0
"""For its body: 1 MiB at half a megabit per second."""

STALL_S = 30.0
"""An answer of which nobody has taken anything for so long is given up; a stream pings every 20 s."""

SPARE_FILES = 384
"""File descriptors that the listener leaves to others: 160 for stops, the database's, the bus's, those of files that
are served, and some connections that are accepted and not sent away yet."""


class Phase(Enum):
    """What a connection is doing."""

    HEAD = "head"
    """Nothing was asked yet, or nothing more."""
    BODY = "body"
    ANSWER = "answer"
    """Being answered, or a stream."""


PATIENCE_S = {Phase.HEAD: HEAD_S, Phase.BODY: BODY_S}


class Visit:
    """One open connection.

    Args:
        transport: the connection.
        address: of the other end, or its network; empty for nobody's.
        protocol: what reads it.
        now_s: a clock.
    """

    def __init__(self, transport: asyncio.Transport, address: str, protocol: Any, now_s: float) -> None:
        self.transport, self.address, self.protocol = transport, address, protocol
        self.taken_s = now_s
        """When the other end had last taken what was sent to it."""
        self._doing: tuple[Phase, object] = (Phase.HEAD, None)
        self._since_s = now_s

    @property
    def phase(self) -> Phase:
        """What it is doing."""
        return self._now()[0]

    def overdue(self, now_s: float) -> bool:
        """Whether it has kept us waiting for too long."""
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
    """Who is connected to one listener.

    Args:
        most: connections in all.
        each: of one address.
        exempt: addresses that speak for many.
        now_s: a clock that never goes back.

    Attributes:
        turned_away: connections that were ended for lack of a place.
        given_up: connections that have kept us waiting for too long.
    """

    def __init__(
        self, *, most: int, each: int, exempt: Iterable[str] = (), now_s: Callable[[], float] = time.monotonic
    ) -> None:
        self._most, self._each, self._exempt, self._now_s = most, each, frozenset(exempt), now_s
        self._visits: dict[asyncio.BaseTransport, Visit] = {}
        """The oldest first."""
        self._of: dict[str, dict[asyncio.BaseTransport, Visit]] = {}
        """The same by address."""
        self.turned_away = 0
        self.given_up = 0

    @property
    def connected(self) -> int:
        """How many there are."""
        return len(self._visits)

    def enter(self, transport: asyncio.Transport, protocol: Any) -> None:
        """Somebody has connected, or an open connection has another protocol now."""
        known = self._visits.get(transport)
        if known is not None:
            known.protocol = protocol
            return
        peer = transport.get_extra_info("peername")
        address = str(peer[0]) if isinstance(peer, tuple) and peer else ""
        address = "" if address in self._exempt else neighbourhood(address)
        visit = Visit(transport, address, protocol, self._now_s())
        others = self._of.get(address, {})
        if (address and len(others) >= self._each and not self._make_room(others.values())) or (
            len(self._visits) >= self._most and not self._make_room(self._visits.values())
        ):
            self._turn_away(visit)
        else:
            self._visits[transport] = visit
            self._of.setdefault(address, {})[transport] = visit

    def leave(self, transport: asyncio.BaseTransport) -> None:
        """A connection has ended; harmless when done twice."""
        visit = self._visits.pop(transport, None)
        if visit is None:
            return
        same = self._of[visit.address]
        del same[transport]
        if not same:
            del self._of[visit.address]

    def flows(self, transport: asyncio.BaseTransport) -> None:
        """The other end has taken what was sent to it."""
        visit = self._visits.get(transport)
        if visit is not None:
            visit.taken_s = self._now_s()

    def sweep(self) -> None:
        """End the connections that keep us waiting."""
        now_s = self._now_s()
        for visit in [visit for visit in self._visits.values() if visit.overdue(now_s)]:
            self.given_up += 1
            self._end(visit)

    def _make_room(self, visits: Iterable[Visit]) -> bool:
        """End the oldest of these connections that keep us waiting, one that has asked for nothing before others."""
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
    """How many connections there can be, so that `SPARE_FILES` are left; the process's own limit is raised for it.

    Args:
        connections: how many are wanted.
    """
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    wanted = connections + SPARE_FILES
    if soft == resource.RLIM_INFINITY or soft >= wanted:
        return connections
    raised = wanted if hard == resource.RLIM_INFINITY else min(hard, wanted)
    resource.setrlimit(resource.RLIMIT_NOFILE, (raised, hard))
    return max(raised - SPARE_FILES, 16)
