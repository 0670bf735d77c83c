"""Operators' agents beside a gateway: one worker each, while the person is on duty (`dray.gateway.factory.duty`)."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import AsyncIterator, Callable, Sequence
from contextlib import asynccontextmanager

from dray.gateway.factory.duty import Employed
from dray.gateway.live.timescale import LOOK_S, TimeScale
from dray.memory import Changes, Memory
from dray.messages import Event
from dray.messages.keys import Keys
from dray.ports import Body, Bus
from dray.protocol.operator.operator import Operator
from dray.worker.worker import Worker

_log = logging.getLogger(__name__)


class _PlantClock:
    """The plant's clock by the gateway's time scale. Implements `dray.ports.Clock`."""

    def __init__(self, time: TimeScale, wall_s: Callable[[], float]) -> None:
        self._time, self._wall_s = time, wall_s
        self._shown_s = time.to_plant_s(wall_s())

    def now_s(self) -> float:
        """See `dray.ports.Clock`."""
        self._shown_s = max(self._shown_s, self._time.to_plant_s(self._wall_s()))
        return self._shown_s

    def call_at(self, when_s: float, callback: Callable[[], None]) -> None:
        """See `dray.ports.Clock`."""
        wait_s = (when_s - self.now_s()) / self._time.speed
        loop = asyncio.get_running_loop()
        if wait_s <= 0:
            loop.call_soon(callback)
        else:
            loop.call_later(min(wait_s, LOOK_S), self.call_at, when_s, callback)


class _NoNotes:
    """An operator's journal, which stores nothing about a person. Implements `dray.ports.Journal`.

    Lives are numbered by their start time, so that the newest counts, at any gateway.
    """

    memory: Memory = {}  # noqa: RUF012 (nothing is ever put in)
    lost = ""

    def __init__(self, incarnation: int) -> None:
        self.incarnation = incarnation

    def write(self, events: Sequence[Event], changes: Changes) -> None:
        """See `dray.ports.Journal`."""

    def kept(self, incarnation: int) -> tuple[int, int]:
        """See `dray.ports.Journal`."""
        return 1, 0

    def earlier(self, before: int, most: int) -> list[tuple[int, int, int]]:
        """See `dray.ports.Journal`."""
        return []

    def events(self, incarnation: int, first: int, last: int) -> list[Event]:
        """See `dray.ports.Journal`."""
        return []


class OperatorWorkers:
    """Implements `dray.gateway.factory.duty.OperatorHost`.

    Args:
        bus: the agents' bus.
        keys: the plant's.
        time: the two clocks.
        wall_s: the wall clock.
    """

    def __init__(self, bus: Bus, keys: Keys, time: TimeScale, wall_s: Callable[[], float]) -> None:
        self._bus, self._keys, self._wall_s = bus, keys, wall_s
        self._clock = _PlantClock(time, wall_s)
        self._workers: dict[str, Worker] = {}
        self._tasks: set[asyncio.Task[None]] = set()

    def employ(self, operator: str, body: Body) -> Employed:
        """Run the agent of a person who goes on duty now."""
        before = self._workers.pop(operator, None)
        if before is not None:
            before.kill()
        # Milliseconds: going off and on duty within a second is another life.
        life = int(self._wall_s() * 1000)
        worker = Worker(
            Operator(operator, self._keys.plant, incarnation=life),
            bus=self._bus,
            clock=self._clock,
            keys=self._keys,
            body=body,
            journal=_NoNotes(life),
        )
        self._workers[operator] = worker
        task = asyncio.get_running_loop().create_task(worker.run(), name=operator)
        self._tasks.add(task)
        task.add_done_callback(self._ended)
        return worker

    def give_way(self, agent: str) -> None:
        """A later life of this operator has joined at another gateway."""
        worker = self._workers.pop(agent, None)
        if worker is not None:
            worker.kill()

    @asynccontextmanager
    async def running(self) -> AsyncIterator[None]:
        """Stop all agents at the end; promises hold for the next life."""
        try:
            yield
        finally:
            for worker in self._workers.values():
                worker.kill()
            await asyncio.gather(*self._tasks, return_exceptions=True)

    def _ended(self, task: asyncio.Task[None]) -> None:
        self._tasks.discard(task)
        if not task.cancelled() and (error := task.exception()) is not None:
            _log.error("the agent of %s has ended by %r", task.get_name(), error)
