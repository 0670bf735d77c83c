"""Some computers on a Zenoh bus, in one process, and a way to know that all that was said has arrived."""

from __future__ import annotations

import asyncio
import selectors
import socket
import time
from collections.abc import Callable, Coroutine, Iterable, Iterator, Sequence
from contextlib import suppress
from typing import Any, TypeVar

import zenoh
from zenoh.handlers import Callback

from dray.adapters.security.identity import Identity
from dray.adapters.zenoh.bus import ZenohBus, ZenohSession
from dray.adapters.zenoh.links import Links
from dray.errors import UnavailableError
from dray_sim.clock.loop import VirtualLoop, paced

T = TypeVar("T")

PATIENCE_S = 90.0
"""For what takes milliseconds on a machine with nothing else to do."""

LEASE_S = PATIENCE_S
"""A link that is silent for two seconds is closed in a factory, and what is under way on it is lost: whoever has said it says it again. A test says it
once, and a computer that is busy elsewhere keeps its links silent for as long: no test here is about that."""

AGAIN_S = 0.1
"""A marker that found no way yet is sent again after this; it is an upper bound of a wait for an event."""


def free_address(host: str = "127.0.0.1") -> str:
    """An address on this computer where nobody listens."""
    with socket.socket() as probe:
        probe.bind((host, 0))
        return f"{host}:{probe.getsockname()[1]}"


def multicast_works() -> bool:
    """Whether this machine lets through what is sent to a multicast group."""
    group, patience_s = "224.0.0.224", 2.0
    with (
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as listener,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as mouth,
    ):
        try:
            listener.bind(("", 0))
            membership = socket.inet_aton(group) + socket.inet_aton("0.0.0.0")
            listener.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, membership)
            listener.settimeout(patience_s)
            mouth.sendto(b"?", (group, listener.getsockname()[1]))
            return listener.recv(1) == b"?"
        except OSError:
            return False


class Row:
    """Computers in a row, each linked with the one before it: the ends hear each other by relays.

    Args:
        count: how many.
        plant: the plant's id.
        identities: of each of them; without any, links are plain.
    """

    def __init__(self, count: int, plant: str = "p", identities: Sequence[Identity] = ()) -> None:
        self.buses: list[ZenohBus] = []
        self._somebody_left = asyncio.Event()
        self._markers: list[zenoh.Subscriber[None]] = []
        before: tuple[str, ...] = ()
        for place in range(count):
            bus, own = _listening(plant, before, identities[place] if identities else None, self._on_replaced)
            self.buses.append(bus)
            before = (own,)
        self._round = 0
        self._marks: set[tuple[int, int]] = set()
        self._complete = asyncio.Event()
        for place, bus in enumerate(self.buses):
            marker = Callback(self._marker(place, bus), indirect=False)
            self._markers.append(bus.inner.declare_subscriber("settle/*", marker))

    async def settle(self) -> None:
        """Wait until all that was asked for before has taken effect, and all that was said has arrived.

        Every computer says a marker, which goes the way of all that was said before it, until every other
        one has heard it; and then another one, for what the first has met on its way and others pass on.
        A router may lose an agent's declaration all the same (`dray.adapters.spares`), and is told of its spare.
        """
        for _ in range(2):
            await self._say_round()
        async with asyncio.timeout(PATIENCE_S):
            while not all(_has_way(bus, session) for bus, session in self._strangers()):
                await asyncio.sleep(AGAIN_S)
                await self._say_round()

    def _strangers(self) -> Iterator[tuple[ZenohBus, ZenohSession]]:
        """Each computer with each agent of another one."""
        for bus in self.buses:
            for other in self.buses:
                if other is not bus:
                    yield from ((bus, session) for session in tuple(other._sessions.values()))

    async def _say_round(self) -> None:
        self._round += 1
        self._marks.clear()
        self._complete.clear()
        async with asyncio.timeout(PATIENCE_S):
            while not self._complete.is_set():
                for place, bus in enumerate(self.buses):
                    bus.inner.put(f"settle/{place}", str(self._round))
                with suppress(TimeoutError):
                    await asyncio.wait_for(self._complete.wait(), AGAIN_S)

    async def left(self, sessions: Iterable[ZenohSession]) -> None:
        """Wait until all of these have left: a later life of each was said, and no marker comes after that for certain."""
        waited_for = tuple(sessions)
        async with asyncio.timeout(PATIENCE_S):
            while not all(session._left for session in waited_for):
                self._somebody_left.clear()
                await self._somebody_left.wait()

    async def met(self, sessions: Iterable[ZenohSession]) -> None:
        """Wait until every computer can write letters to all of these: with certificates it has met their tokens, in whatever order."""
        waited_for = tuple(sessions)
        async with asyncio.timeout(PATIENCE_S):
            while not all(_has_met(bus, session) for bus in self.buses for session in waited_for):
                await self._say_round()

    def _on_replaced(self, _agent: str) -> None:
        self._somebody_left.set()

    def told(self) -> str:
        """What each computer has counted, for whoever looks into a test that has failed."""
        lines = [
            f"{place}: delivered {bus.delivered}, missed {bus.missed}, refused {dict(bus.refused)}, unsaid {bus.unsaid}, "
            f"unaddressed {bus.unaddressed}, dropped {bus.arrivals.dropped_messages}, failures {bus.failures.total}"
            for place, bus in enumerate(self.buses)
        ]
        return "\n".join(lines)

    def close(self) -> None:
        for marker in self._markers:
            with suppress(zenoh.ZError):  # its bus is closed already
                marker.undeclare()
        for bus in self.buses:
            bus.leave()
        for bus in self.buses:
            bus.close()

    def _marker(self, place: int, bus: ZenohBus) -> Any:
        def on_message(sample: zenoh.Sample) -> None:
            sender = int(str(sample.key_expr).rpartition("/")[2])
            bus.arrivals.order(self._mark, place, sender, int(sample.payload.to_string()))

        return on_message

    def _mark(self, place: int, sender: int, round_number: int) -> None:
        if round_number == self._round:
            self._marks.add((place, sender))
            if len(self._marks) == len(self.buses) ** 2:
                self._complete.set()


def _has_way(bus: ZenohBus, session: ZenohSession) -> bool:
    """Whether what is said here to the agent alone is passed on to it."""
    if session._left:
        return True
    publisher = bus.inner.declare_publisher(session._own.key_expr)
    try:
        status: Any = publisher.matching_status  # Zenoh's stub says that it is a bool.
        return bool(status.matching)
    finally:
        publisher.undeclare()


def _has_met(bus: ZenohBus, session: ZenohSession) -> bool:
    """Whether letters from this computer reach the agent."""
    theirs = session._bus.seals
    if bus.seals is None or theirs is None or session._left:
        return True
    return bus.seals.register.has(session.agent, theirs.certificate)


def _listening(
    plant: str, peers: tuple[str, ...], identity: Identity | None, replaced: Callable[[str], None]
) -> tuple[ZenohBus, str]:
    """A computer on a free port, and its address."""

    def listen(own: str) -> tuple[ZenohBus, str]:
        plain = identity is None
        links = Links(listen=(own,), peers=peers, identity=identity, plain=plain, lease_s=LEASE_S)
        return ZenohBus(links, plant, replaced), own

    with suppress(UnavailableError):  # somebody else was quicker
        return listen(free_address())
    return listen(free_address())


LONGEST_STEP_S = 0.02
"""By which real time goes on at once, where it is patient: less than half a second of such a factory."""


class ShortSleeps(selectors.DefaultSelector):
    """Wakes up so often that no sleep is taken for a pause of the computer."""

    def select(self, timeout: float | None = None) -> list[tuple[selectors.SelectorKey, int]]:
        return super().select(LONGEST_STEP_S if timeout is None else min(timeout, LONGEST_STEP_S))


class PatientTime:
    """Real time without the moments in which the computer was busy elsewhere: its pauses are nobody's silence."""

    def __init__(self) -> None:
        self._now_s, self._looked_s = 0.0, time.monotonic()

    def __call__(self) -> float:
        looked_s = time.monotonic()
        self._now_s += min(looked_s - self._looked_s, LONGEST_STEP_S)
        self._looked_s = looked_s
        return self._now_s


def run_patiently(main: Coroutine[Any, Any, T], speed: float) -> T:
    """Run this to its end at so many virtual seconds per real one, or slower on a computer that is busy."""

    def loop() -> VirtualLoop:
        return VirtualLoop(paced(speed), selector=ShortSleeps(), wall_s=PatientTime())

    with asyncio.Runner(loop_factory=loop) as runner:
        return runner.run(main)
