"""Every bus that there is, each in a world of its own, for the conformance suite of `dray.ports.Bus`."""

from __future__ import annotations

import asyncio
from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Callable, Coroutine, Mapping, Sequence
from itertools import cycle
from pathlib import Path
from random import Random
from typing import Any

from zenoh_kit import Row

from dray.adapters.security.identity import Identity
from dray.adapters.zenoh.bus import ZenohSession
from dray.messages import Pose
from dray.messages.kinds import Kind
from dray.ports import Bus, Receive, Session
from dray_sim.clock.loop import VirtualLoop, clock, paced, run
from dray_sim.faults import LinkTrouble, Partition, WlanCut
from dray_sim.network.bridge import BridgedBus, SimThread
from dray_sim.network.coverage import Coverage, Hole
from dray_sim.network.latency import WLAN
from dray_sim.network.sim_network import SimNetwork

STRATEGISTS = (
    *(
        "A",
        "B",
        "C",
        "L",
        "S",
        "T",
        "A1",
        "A2",
        "A11",
        "M1",
        "x",
        "a",
        "k",
        "y",
        "hb",
        "atv",
        "machine",
        "event",
    ),
    *(f"A{number}" for number in range(10)),
)
"""Names of agents that say here what strategists do."""


KINDS: Mapping[str, Kind] = {
    **dict.fromkeys(STRATEGISTS, Kind.STRATEGIST),
    "R1": Kind.ATV,
    "R2": Kind.ATV,
    "W1": Kind.MACHINE,
    "W2": Kind.MACHINE,
}
"""What the agents of these tests are, where anybody knows it."""


NOBODY: Mapping[str, Kind] = {}


class World(ABC):
    """A bus, and the loop on which it is used.

    Attributes:
        bus: there while `run` runs.
        refused: what nobody heard because its speaker may not say it, by reason.
    """

    bus: Bus

    @property
    @abstractmethod
    def refused(self) -> Mapping[str, int]: ...

    def told(self) -> str:
        """What was counted on the bus, for whoever looks into a test that has failed."""
        return f"refused: {dict(self.refused)}"

    @abstractmethod
    def run(self, test: Coroutine[Any, Any, None]) -> None:
        """Run a test with the bus."""

    @abstractmethod
    async def settle(self) -> None:
        """Wait until all that was asked for before has taken effect, and all that was said has arrived."""


class InProcess(World):
    """The simulated network, which knows of some agents what they are."""

    def __init__(self, *, codec: bool = False, kinds: Mapping[str, Kind] = NOBODY) -> None:
        self._codec, self._kinds = codec, kinds

    @property
    def refused(self) -> Mapping[str, int]:
        assert isinstance(self.bus, SimNetwork)
        return self.bus.refused

    def run(self, test: Coroutine[Any, Any, None]) -> None:
        async def main() -> None:
            self.bus = network = SimNetwork(clock(), Random(7), codec=self._codec)
            network.kinds.update(self._kinds)
            await test

        run(main())

    async def settle(self) -> None:
        await asyncio.sleep(WLAN.cap_s)


class Ill(InProcess):
    """Faults are active, and none of them concerns the agents of the test: nothing may change for them."""

    def run(self, test: Coroutine[Any, Any, None]) -> None:
        async def main() -> None:
            network = SimNetwork(clock(), Random(7), coverage=Coverage(holes=[Hole(0.0, 0.0, 1.0)]))
            network.equip("V", lambda: Pose(0.0, 0.0, 0.0), lambda *_: None)
            for fault in (WlanCut("V"), LinkTrouble(sender="V*", loss_frac=1.0), Partition((("V",),))):
                network.begin(fault)
            self.bus = network
            await test

        run(main())


class Bridged(World):
    """The agents of the test live on an ordinary loop, the network in a thread on virtual time."""

    SPEED = 1e6
    """A second in a microsecond: paced, and yet nobody waits."""

    @property
    def refused(self) -> Mapping[str, int]:
        return self._network.refused

    def run(self, test: Coroutine[Any, Any, None]) -> None:
        async def live_inside(ready: Any) -> None:
            ready(SimNetwork(clock(), Random(7)))
            await asyncio.Event().wait()

        async def main() -> None:
            thread: SimThread[SimNetwork] = SimThread(live_inside, paced(self.SPEED))
            network = self._network = thread.start(timeout_s=10.0)
            try:
                self.loop: VirtualLoop = thread.loop
                self.bus = self.bridge = BridgedBus(network, thread.loop, asyncio.get_running_loop())
                await test
            finally:
                thread.stop()

        asyncio.run(main())

    async def settle(self) -> None:
        # A marker that goes the way of all that was said before it, with the longest delay of all.
        settled = asyncio.Event()
        inside = self.loop.clock

        def come_back() -> None:
            self.bridge.outbound.order(settled.set)

        def wait_inside() -> None:
            inside.call_at(inside.now_s() + WLAN.cap_s, come_back)

        self.bridge.inbound.order(wait_inside)
        await settled.wait()


class OnZenoh(World):
    """Zenoh sessions on one computer, each with every so manyth agent; the outer ones hear one another by relay.

    So an agent that joins again under its name does so in another session, as after a restart elsewhere.
    """

    def __init__(self, count: int, identities: Sequence[Identity] = ()) -> None:
        self._count, self._identities = count, identities
        self._sessions: list[ZenohSession] = []

    @property
    def refused(self) -> Mapping[str, int]:
        return sum((bus.refused for bus in self._row.buses), Counter[str]())

    def told(self) -> str:
        return self._row.told()

    def run(self, test: Coroutine[Any, Any, None]) -> None:
        async def main() -> None:
            self._row = Row(self._count, identities=self._identities)
            self._turns = cycle(self._row.buses)
            self.bus = self
            try:
                await test
            finally:
                self._row.close()

        asyncio.run(main())

    def join(self, agent: str, receive: Receive, life: int = 0) -> Session:
        self._sessions.append(next(self._turns).join(agent, receive, life))
        return self._sessions[-1]

    async def settle(self) -> None:
        await self._row.settle()
        latest: dict[str, int] = {}
        for session in self._sessions:
            latest[session.agent] = max(session.life, latest.get(session.agent, 0))
        await self._row.left(each for each in self._sessions if each.life < latest[each.agent])
        await self._row.met(self._sessions)


class Certified(OnZenoh):
    """The same with certificates: every session has one of its own, and may speak for every agent of the tests."""

    COUNT = 3

    def __init__(self, folder: Path) -> None:
        own = [Identity.in_folder(folder / str(place), next(iter(KINDS))) for place in range(self.COUNT)]
        super().__init__(self.COUNT, own)


WORLDS: Mapping[str, Callable[[Path], World]] = {
    "in-process": lambda _: InProcess(),
    "in-process, on the wire format": lambda _: InProcess(codec=True),
    "in-process, while others suffer": lambda _: Ill(),
    "bridged": lambda _: Bridged(),
    "Zenoh, one session": lambda _: OnZenoh(1),
    "Zenoh, three sessions in a row": lambda _: OnZenoh(3),
    "Zenoh with certificates": Certified,
}
