"""`dray up` whose time passes only when a test says so.

Usage: python stepped_up.py [options of `dray up`]

The clock on the wall of this process, by which the factory is paced and the gateway tells the time, stands until it is moved
over a socket of its own: lines of JSON, each answered by one. `{"advance_s": 2.5}` lets so much factory time pass,
`{"goes": true}` lets it pass as real time does at the factory's speed until `{"goes": false}`. The answer tells the plant's
clock once all has been said, heard and written into history that was to be by then.
"""

from __future__ import annotations

import asyncio
import json
import selectors
import socket
import sys
import time
from contextlib import suppress
from functools import partial
from typing import TYPE_CHECKING, Any

from dray.cli import main as run
from dray.cli.runtime.gateway import service
from dray.cli.simulation import one_process
from dray.store.historian import Historian
from dray_sim.clock.wall import Wall

if TYPE_CHECKING:
    from dray.adapters.crossing import Crossing
    from dray_sim.clock.loop import VirtualLoop

QUANTUM_S = 0.25
"""Factory time that passes at once: agents allow for twice as much before anything counts as late."""

WALL_PER_REAL = 10.0
"""Wall time that passes in real time at most, so that panels and what is kept of them have no gaps."""

NO_TIME_S = 1e-3
"""So little factory time is none: unix time in a float has a quarter of a microsecond, and the factory is faster."""

BEHIND_S, DAY_S = 900.0, 86_400.0
"""So far it is behind the computer's clock at first, on the same day: more than tests let pass in one factory."""

TICK_S = 0.02
"""Real time from move to move while the clock goes."""


ROUNDING_S = 1e-6
"""Less is no time to sleep."""


class UntilWoken(selectors.DefaultSelector):
    """Sleeps until something comes: nothing is due before the clock is moved, and whoever moves it says so."""

    def select(self, timeout: float | None = None) -> list[tuple[selectors.SelectorKey, int]]:
        # What rounding has left counts as due (`loop.TICK_S`).
        return super().select(0 if timeout is not None and timeout < ROUNDING_S else None)


class SteppedClock:
    """The clock on the wall, and who moves it.

    Attributes:
        address: where it is told to.
    """

    def __init__(self) -> None:
        # A browser goes by the computer's clock until it is told another time: nothing is to lie in its future.
        now_s = time.time()
        self._now_s = max(now_s - BEHIND_S, now_s - now_s % DAY_S)
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.address = f"127.0.0.1:{self._listener.getsockname()[1]}"
        self.wall = Wall(lambda: self._now_s, UntilWoken(), self._met)
        self._factory: VirtualLoop
        self._outbound: Crossing
        self._moves = asyncio.Lock()
        self._going: asyncio.Task[None] | None = None
        self._serving: asyncio.Task[None] | None = None
        self._historian: Historian | None = None

    def historian(self, **options: Any) -> Historian:
        """Make the historian of this process: it writes at once what it hears."""
        self._historian = Historian(**(options | {"linger_s": 0.0}))
        return self._historian

    def _met(self, factory: VirtualLoop, outbound: Crossing) -> None:
        self._factory, self._outbound = factory, outbound
        self._serving = asyncio.get_running_loop().create_task(self._serve())

    async def _serve(self) -> None:
        async with await asyncio.start_server(self._talk, sock=self._listener) as server:
            await server.serve_forever()

    async def _talk(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        while line := await reader.readline():
            asked = json.loads(line)
            if "goes" in asked:
                await self._go(goes=asked["goes"])
            await self._advance(asked.get("advance_s", 0.0))
            writer.write(
                json.dumps({"plant_s": self._factory.due_s(), "wall_s": self._now_s}).encode() + b"\n"
            )
            await writer.drain()
        writer.close()

    async def _go(self, *, goes: bool) -> None:
        if self._going is not None:
            self._going.cancel()
            with suppress(asyncio.CancelledError):
                await self._going
        self._going = asyncio.create_task(self._keep_going()) if goes else None

    async def _keep_going(self) -> None:
        before_s = time.monotonic()
        while True:
            await asyncio.sleep(TICK_S)
            now_s = time.monotonic()
            async with self._moves:
                await self._move(min(now_s - before_s, QUANTUM_S) * self._speed)
            before_s = now_s

    async def _advance(self, span_s: float) -> None:
        async with self._moves:
            until_s = self._factory.due_s() + span_s
            while (left_s := until_s - self._factory.due_s()) > NO_TIME_S:
                moved_s = min(left_s, QUANTUM_S)
                began_s = time.monotonic()
                await self._move(moved_s)
                least_s = moved_s / self._speed / WALL_PER_REAL
                await asyncio.sleep(max(0.0, began_s + least_s - time.monotonic()))
            await self._move(0.0)
        await self._kept()

    async def _kept(self) -> None:
        """Return when what was heard is written; a database that cannot be written is not waited for."""
        if (historian := self._historian) is None:
            return
        written = asyncio.create_task(historian.written())
        while not written.done() and not historian.failing and not self._factory.is_closed():
            await asyncio.wait({written}, timeout=1.0)
        written.cancel()

    @property
    def _speed(self) -> float:
        return self._factory.pace.speed

    async def _move(self, span_s: float) -> None:
        """Move the clock, and return when the gateway has heard all that was said until then."""
        heard: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        self._now_s += span_s / self._speed
        self._factory.call_soon_threadsafe(self._catch_up, heard)
        # A factory that has ended answers nobody.
        while not heard.done() and not self._factory.is_closed():
            await asyncio.wait({heard}, timeout=1.0)

    def _catch_up(self, heard: asyncio.Future[None]) -> None:
        """On the factory's thread: what is due comes first, then the answer."""

        def answer() -> None:
            if not heard.done():
                heard.set_result(None)

        self._factory.clock.call_at(self._factory.due_s(), partial(self._outbound.order, answer))


def main() -> None:
    """Run `dray up` by a clock that stands."""
    clock = SteppedClock()
    sys.stdout.write(f"Clock {clock.address}\n")
    sys.stdout.flush()
    one_process.run_service = partial(one_process.run_service, wall=clock.wall)
    service.Historian = clock.historian
    sys.argv[1:1] = ["up"]
    run()


if __name__ == "__main__":
    main()
