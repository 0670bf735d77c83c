"""Vehicles in a row, some of them without WLAN, and a machine that listens on the bus, for tests."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Coroutine
from dataclasses import replace
from random import Random

import msgspec

from dray.messages import (
    AtvHeartbeat,
    AtvStatus,
    Link,
    Message,
    Pose,
)
from dray_sim.clock.loop import clock, run
from dray_sim.faults import WlanCut
from dray_sim.network.coverage import Coverage
from dray_sim.network.modem import NOTICE_S, Notice
from dray_sim.network.radio import RADIO, RadioSpec
from dray_sim.network.sim_network import SimNetwork
from dray_sim.run.trace import Trace

CLEAR = replace(RADIO, loss_frac=0.0)
"""Reaches 25 m and loses nothing, so that a test may count."""


SOON_S = 2.0
"""By then everything has arrived: four hops and a slow WLAN take one second at most."""


class Floor:
    """Vehicles on a line, a machine M and a gateway G on the wire, and what each has heard.

    Args:
        places_m: where the vehicles V0, V1, ... stand.
    """

    def __init__(
        self,
        *places_m: float,
        radio: RadioSpec = CLEAR,
        coverage: Coverage | None = None,
        trace: Trace | None = None,
        codec: bool = False,
    ) -> None:
        self.network = SimNetwork(
            clock(), Random(1), chance=Random(1), radio=radio, coverage=coverage, trace=trace, codec=codec
        )
        self.places_m = dict(enumerate(places_m))
        self.heard: dict[str, list[tuple[str, Message]]] = {}
        self.noticed: dict[str, list[tuple[float, Link]]] = {}
        self.served: dict[str, list[str]] = {}
        """By vehicle, which access points its modem has named with that."""
        self.sessions = {}
        for number in self.places_m:
            name = f"V{number}"
            self.noticed[name], self.served[name] = [], []
            self.network.equip(name, self._where(number), self._notice(name))
            self.join(name)
        for name in "MG":
            self.join(name)
            self.sessions[name].subscribe("p/hb/**")

    def join(self, name: str) -> None:
        heard = self.heard.setdefault(name, [])
        self.sessions[name] = self.network.join(name, lambda *said: heard.append(said))

    def _where(self, number: int) -> Callable[[], Pose]:
        return lambda: Pose(self.places_m[number], 0.0, 0.0)

    def _notice(self, name: str) -> Notice:
        def notice(link: Link, access_point: str) -> None:
            self.noticed[name].append((clock().now_s(), link))
            self.served[name].append(access_point)

        return notice

    async def cut(self, *names: str) -> None:
        """Take the WLAN of these vehicles, and wait until they have noticed."""
        for name in names:
            self.network.begin(WlanCut(name))
        await asyncio.sleep(NOTICE_S)

    def beat(self, name: str, **fields: object) -> None:
        self.sessions[name].publish(f"p/hb/atv/{name}", heartbeat(name, **fields))

    async def beat_and_wait(self, name: str, **fields: object) -> None:
        self.beat(name, **fields)
        await asyncio.sleep(SOON_S)

    def beats(self, name: str) -> list[AtvHeartbeat]:
        """The heartbeats that somebody has heard."""
        return [said for _, said in self.heard[name] if isinstance(said, AtvHeartbeat)]


def heartbeat(atv: str, **fields: object) -> AtvHeartbeat:
    beat = AtvHeartbeat(atv, 1, 1, 0.0, AtvStatus.WORKING, Pose(0.0, 0.0, 0.0), "n1", 1.0, 0.5)
    return msgspec.structs.replace(beat, **fields)


def play(story: Coroutine[object, object, None]) -> None:
    run(story)
