"""A floor with its bodies, and agents elsewhere that use them, on a Zenoh bus in one process, for tests."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Collection, Coroutine
from random import Random
from typing import Any

from zenoh_kit import PATIENCE_S, Row, run_patiently

from dray.adapters.remote_body import BodySpec, RemoteBody
from dray.adapters.zenoh.bus import ZenohBus
from dray.body import Report
from dray.plant import default_plant
from dray_sim.bodies.floor import Floor
from dray_sim.clock.loop import clock
from dray_sim.remote import FloorServer

PLANT = default_plant()

SPEED = 20.0

ATV = next(iter(PLANT.fleet))


class House:
    """A floor in one session, the session of its agents, and one for the floor that comes after it."""

    def __init__(self, row: Row, group: asyncio.TaskGroup, foreign: Collection[str] = ()) -> None:
        self._row, self._group, self._foreign = row, group, foreign
        self.here = row.buses[1].inner
        self.there = row.buses[0].inner
        self.refusal: Callable[[BodySpec], str] = lambda _: ""
        """Why one more body cannot be put down."""
        self.floor, self.serving = self._serve(row.buses[0])
        self.settle = row.settle

    def end(self) -> None:
        """The floor's process ends."""
        self.serving.cancel()
        self.server.end()
        self._row.buses[0].close()

    def begin_anew(self) -> None:
        """The floor's process ends, and another one starts."""
        self.end()
        self.floor, self.serving = self._serve(self._row.buses[2])

    def _serve(self, bus: ZenohBus) -> tuple[Floor, asyncio.Task[None]]:
        floor = Floor(PLANT, clock(), seed=1)
        self.server = FloorServer(bus.inner, PLANT.id, floor, self._refuse, self._foreign)
        return floor, self._group.create_task(self.server.run())

    def _refuse(self, spec: BodySpec) -> str:
        return self.refusal(spec)

    async def take_over(self, agent: str, life: int, session: Any = None) -> RemoteBody:
        body = RemoteBody(session or self.here, PLANT.id, agent, life)
        await body.connect()
        return body


def in_a_house(test: Callable[[House], Coroutine[Any, Any, None]], foreign: Collection[str] = ()) -> None:
    async def main() -> None:
        row = Row(3, PLANT.id)
        try:
            async with asyncio.TaskGroup() as group:
                house = House(row, group, foreign)
                await row.settle()
                await test(house)
                house.serving.cancel()
        finally:
            row.close()

    run_patiently(main(), SPEED)


class Listener:
    """What a body reports, and a way to wait for it."""

    def __init__(self, body: RemoteBody) -> None:
        self.reports: list[Report] = []
        self._came = asyncio.Event()
        body.attach(self._on_report)

    def _on_report(self, report: Report) -> None:
        self.reports.append(report)
        self._came.set()

    async def until(self, kind: type[Report]) -> None:
        async with asyncio.timeout(PATIENCE_S * SPEED):
            while not any(type(report) is kind for report in self.reports):
                self._came.clear()
                await self._came.wait()


def way_of(vehicle: str) -> tuple[str, ...]:
    """A way of the vehicle from where it stands to a machine."""
    spec = PLANT.fleet[vehicle]
    goal = PLANT.node_of(next(iter(PLANT.machines)))
    return PLANT.routes(spec.type).way(spec.node, goal).nodes


class Leaky:
    """A session that lets only some of what is said through."""

    def __init__(self, session: Any, seed: int, through_frac: float = 0.25) -> None:
        self._session, self._random, self._through_frac = session, Random(seed), through_frac

    def __getattr__(self, name: str) -> Any:
        return getattr(self._session, name)

    def put(self, key: str, data: bytes) -> None:
        if self._random.random() < self._through_frac:
            self._session.put(key, data)
