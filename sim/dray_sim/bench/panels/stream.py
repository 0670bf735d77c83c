"""Benchmark `stream`: the bytes that a plant sends to one panel, and the cost of making them.

A simulated factory runs on the virtual clock, the gateway's projection hears it, and frames are made ten times a
second as for a browser. The last case is a crowd of vehicles that are all at work, which no factory reaches. The
baseline is the same frames with whole entities, as they are in the projection, sent as they are. Bytes are counted,
so they are the same on every machine. They are compressed as the websocket does it (RFC 7692: one context for all
frames of a client, a window of 4 KiB).
"""

from __future__ import annotations

import asyncio
import time
import zlib
from dataclasses import dataclass
from random import Random

import msgspec

from dray.gateway.live.frames import Delta
from dray.gateway.live.projection import Projection
from dray.gateway.live.timescale import TimeScale
from dray.gateway.live.updates import Updates
from dray.messages.keys import Keys
from dray.plant import Plant, default_plant
from dray_sim.bench.panels.crowd import Crowd
from dray_sim.bench.row import Row
from dray_sim.clock.loop import clock, run
from dray_sim.factory.sim_factory import SimFactory
from dray_sim.people import demand
from dray_sim.people.order_client import OrderClient
from dray_sim.plants.generator import generate_plant

SEED = 1
LOAD = 0.85
RATE_HZ = 10.0
WARM_UP_S = 600.0
"""Virtual time before bytes are counted: transports run."""

CROWD_WARM_UP_S = 30.0
"""The same of a crowd, which drives from the beginning."""

SPAN_S, QUICK_SPAN_S = 60.0, 10.0
"""Wall seconds in which they are counted."""

LEFT_OUT_BYTES = 4
"""An empty block that ends each flush; the protocol leaves it out."""

WINDOW_BITS, MEMORY_LEVEL = 12, 5
"""The settings that uvicorn offers."""


@dataclass(frozen=True, slots=True)
class Size:
    """One plant to watch."""

    atvs: int
    machines: int
    speed: float
    target_kb_per_s: float | None = None
    default: bool = False

    def plant(self) -> Plant:
        return default_plant() if self.default else generate_plant(SEED, self.machines, self.atvs)


SIZES = (
    Size(atvs=8, machines=12, speed=5.0, target_kb_per_s=15.0, default=True),
    Size(atvs=50, machines=20, speed=1.0),
    Size(atvs=200, machines=80, speed=1.0),
    Size(atvs=1000, machines=300, speed=1.0, target_kb_per_s=150.0),
)
QUICK_SIZES = SIZES[:2]


class Line:
    """Counts the bytes of one websocket, and the bytes that whole entities would take."""

    def __init__(self) -> None:
        self._updates = Updates()
        self._encoder = msgspec.json.Encoder()
        self._compressor = zlib.compressobj(wbits=-WINDOW_BITS, memLevel=MEMORY_LEVEL)
        self.begin()

    def begin(self) -> None:
        """Count from here."""
        self.frames = self.whole_bytes = self.plain_bytes = self.bytes = 0
        self.spent_s = self.whole_s = 0.0

    def send(self, delta: Delta) -> None:
        """Count one frame."""
        start_s = time.perf_counter()
        whole = self._encoder.encode(delta)
        written_s = time.perf_counter()
        self._updates.note(delta)
        frame = self._encoder.encode(self._updates.frame(delta.number, delta.at_s))
        small = self._compressor.compress(frame) + self._compressor.flush(zlib.Z_SYNC_FLUSH)
        self.spent_s += time.perf_counter() - written_s
        self.whole_s += written_s - start_s
        self.frames += 1
        self.whole_bytes += len(whole)
        self.plain_bytes += len(frame)
        self.bytes += len(small) - LEFT_OUT_BYTES


def measure(quick: bool) -> list[Row]:
    """Measure the stream.

    Args:
        quick: a sixth of the time, and the two small plants only.
    """
    span_s = QUICK_SPAN_S if quick else SPAN_S
    rows = []
    for size in QUICK_SIZES if quick else SIZES:
        name = f"stream: {size.atvs} ATVs, {size.machines} machines, at {size.speed:g} x"
        rows.append(_row(name, size.target_kb_per_s, run(_watch(size, span_s)), span_s))
    size = QUICK_SIZES[-1] if quick else SIZES[-1]
    name = f"stream: {size.atvs} ATVs, all at work, at 1 x"
    return [*rows, _row(name, size.target_kb_per_s, _watch_crowd(size.atvs, span_s), span_s)]


def _row(name: str, target_kb_per_s: float | None, line: Line, span_s: float) -> Row:
    return Row(
        name,
        line.bytes / span_s / 1000.0,
        "kB/s",
        line.whole_bytes / span_s / 1000.0,
        "whole entities, not compressed",
        target_kb_per_s,
        note=(
            f"{line.plain_bytes / span_s / 1000.0:.3g} kB/s before it is compressed; "
            f"a frame costs {1e6 * line.spent_s / line.frames:,.0f} us, whole {1e6 * line.whole_s / line.frames:,.0f} us"
        ),
        less=True,
    )


async def _watch(size: Size, span_s: float) -> Line:
    """Run a factory, and send its frames to a panel."""
    plant, line = size.plant(), Line()
    factory = SimFactory(plant, clock(), seed=SEED)
    projection = Projection(plant.file, TimeScale(0.0, 0.0, size.speed))
    session = factory.bus.join("panel", lambda _sender, message: projection.fold(message))
    keys = Keys(plant.id)
    session.subscribe(keys.all_heartbeats)
    session.subscribe(keys.all_events)
    orders = demand.orders(plant, Random(SEED), load=LOAD, until_s=WARM_UP_S + span_s * size.speed)
    lives = [
        asyncio.create_task(factory.run()),
        asyncio.create_task(OrderClient(factory.bus, factory.clock).place(orders)),
    ]
    await asyncio.sleep(WARM_UP_S)
    line.send(projection.delta(0, WARM_UP_S / size.speed, None))
    line.begin()
    for number in range(1, round(span_s * RATE_HZ) + 1):
        await asyncio.sleep(size.speed / RATE_HZ)
        wall_s = factory.clock.now_s() / size.speed
        factory_view = projection.factory(wall_s) if number % RATE_HZ == 0 else None
        line.send(projection.delta(number, wall_s, factory_view))
    for life in lives:
        life.cancel()
    await asyncio.gather(*lives, return_exceptions=True)
    return line


def _watch_crowd(atvs: int, span_s: float) -> Line:
    """Send the frames of a crowd of vehicles that never rest."""
    crowd, line = Crowd(atvs), Line()
    projection = Projection(crowd.plant.file, TimeScale(0.0, 0.0, 1.0))
    for message in crowd.transports():
        projection.fold(message)
    settled = round(CROWD_WARM_UP_S * RATE_HZ)
    for number in range(1, settled + round(span_s * RATE_HZ) + 1):
        now_s = number / RATE_HZ
        for message in crowd.until(now_s):
            projection.fold(message)
        line.send(
            projection.delta(number, now_s, projection.factory(now_s) if number % RATE_HZ == 0 else None)
        )
        if number == settled:
            line.begin()
    return line
