"""Benchmark `replay`: the cost of recording the panels' picture, and how long it takes to show one past moment.

Some minutes of the default plant at work are recorded as the gateway records them, ten frames a second. The cost
stands beside the same frames as they were sent, uncompressed. Then 14 days of such recordings are put into a
database. Random moments are read from SQL, decoded, played, and written as the answer of `GET /api/replay/film`. The
baseline is the requirement, a second.
"""

from __future__ import annotations

import asyncio
import time
import zlib
from random import Random
from statistics import median

import msgspec

from dray.gateway.access.principal import ADMIN
from dray.gateway.live.projection import Projection
from dray.gateway.live.replay.reader import ReplayReader
from dray.gateway.live.replay.recorder import WHOLE_EVERY_S, WRITE_EVERY_S, Recorder
from dray.gateway.live.stream import Hub
from dray.gateway.live.timescale import TimeScale
from dray.messages.keys import Keys
from dray.plant import default_plant
from dray.store import Store, open_store
from dray.store.replay.recordings import Piece
from dray_sim.bench.postgres import databases
from dray_sim.bench.row import Row
from dray_sim.clock.loop import clock, run
from dray_sim.factory.sim_factory import SimFactory
from dray_sim.people import demand
from dray_sim.people.order_client import OrderClient

STEP_S = 0.1
"""Period of the stream's frames."""

DAY_S = 86_400.0

BEGIN_S = 1_800_000_000.0

DAYS, QUICK_DAYS = 14, 1

MOMENTS, QUICK_MOMENTS = 100, 20

BATCH = 500
"""Pieces per transaction while the database is filled."""

REQUIRED_MS = 1_000.0


def measure(quick: bool) -> list[Row]:
    """Measure both databases; PostgreSQL where it is installed.

    Args:
        quick: a day, and fewer moments.
    """
    pieces, live = _recorded(2 * WHOLE_EVERY_S)
    rows = [_size(pieces)]
    with databases() as both:
        for name, url in both.items():
            rows.append(asyncio.run(_moments(name, url, pieces, live, quick)))
    return rows


def _recorded(length_s: float) -> tuple[list[Piece], Projection]:
    plant, now_s = default_plant(), [BEGIN_S]
    projection = Projection(plant.file, TimeScale(0.0, BEGIN_S))
    pieces: list[Piece] = []

    async def main() -> None:
        store: Store = msgspec.UNSET  # type: ignore[assignment]  # nothing is written here
        recorder = Recorder(projection, store, lambda: now_s[0], name="bench", kept_s=DAYS * DAY_S)
        hub = Hub(
            projection,
            wall_s=lambda: now_s[0],
            steady_s=lambda: now_s[0],
            rate_hz=10.0,
            queue_frames=4,
            clients=1,
            each=1,
            record=recorder.note,
        )
        factory = SimFactory(plant, clock(), seed=18)
        session = factory.bus.join("panel", lambda _sender, message: projection.fold(message))
        session.subscribe(Keys(plant.id).all_heartbeats)
        session.subscribe(Keys(plant.id).all_events)
        # Vehicles have work before the recording begins.
        warm_s = 300.0
        orders = demand.orders(plant, Random(18), load=0.85, until_s=length_s + warm_s)
        async with asyncio.TaskGroup() as group:
            tasks = [
                group.create_task(factory.run()),
                group.create_task(OrderClient(factory.bus, factory.clock).place(orders)),
            ]
            await asyncio.sleep(warm_s)
            now_s[0] += warm_s
            for step in range(int(length_s / STEP_S)):
                await asyncio.sleep(STEP_S)
                now_s[0] += STEP_S
                if step % 10 == 0:
                    projection.look(now_s[0])
                hub.tick()
                if step % int(WRITE_EVERY_S / STEP_S) == 0:
                    recorder.cut()
            for task in tasks:
                task.cancel()
        pieces.extend(lines.piece for lines in recorder.lines())

    run(main())
    return pieces, projection


def _size(pieces: list[Piece]) -> Row:
    lasted_s = pieces[-1].until_at_s - pieces[0].from_at_s
    kept = sum(len(piece.frames) for piece in pieces)
    told = sum(len(zlib.decompress(piece.frames)) for piece in pieces)
    a_day_mb = DAY_S / lasted_s / 1e6
    return Row(
        name="replay: a day of the default plant, kept",
        figure=kept * a_day_mb,
        unit="MB",
        baseline=told * a_day_mb,
        baseline_name="the frames as they are told",
        less=True,
        note=f"{len(pieces)} pieces in {lasted_s:.0f} s, {kept / lasted_s / 1e3:.2f} kB/s",
    )


async def _moments(name: str, url: str, pieces: list[Piece], live: Projection, quick: bool) -> Row:
    days, count = (QUICK_DAYS, QUICK_MOMENTS) if quick else (DAYS, MOMENTS)
    store = await open_store(url)
    try:
        end_s = await _fill(store, pieces, days)
        reader = ReplayReader(store, None, live)
        chance, took_ms = Random(1), []
        for _ in range(count):
            at_s = chance.uniform(BEGIN_S + WHOLE_EVERY_S, end_s)
            begun_s = time.perf_counter()
            await reader.film(ADMIN, at_s, at_s, 0.0, msgspec.json.encode)
            took_ms.append(1e3 * (time.perf_counter() - begun_s))
        async with store.read() as work:
            kept = await work.recordings.bytes_kept()
    finally:
        await store.close()
    return Row(
        name=f"replay: first picture anywhere in {days} d, {name}",
        figure=sorted(took_ms)[int(0.95 * len(took_ms))],
        unit="ms",
        baseline=REQUIRED_MS,
        baseline_name="what is required",
        target=REQUIRED_MS,
        less=True,
        note=f"95 of 100 moments; median {median(took_ms):.0f}, worst {max(took_ms):.0f} ms; {kept / 1e6:,.0f} MB of frames",
    )


async def _fill(store: Store, pieces: list[Piece], days: int) -> float:
    """Put the pieces into the database again and again, one after the other; returns where they end."""
    lasted_s = pieces[-1].until_at_s - pieces[0].from_at_s
    shift_s, batch, end_s = BEGIN_S - pieces[0].from_at_s, [], BEGIN_S
    for round_ in range(int(days * DAY_S / lasted_s)):
        by_s = shift_s + round_ * lasted_s
        batch += [
            msgspec.structs.replace(
                piece, from_at_s=piece.from_at_s + by_s, until_at_s=piece.until_at_s + by_s
            )
            for piece in pieces
        ]
        end_s = batch[-1].until_at_s
        if len(batch) >= BATCH:
            await _write(store, batch)
            batch = []
    await _write(store, batch)
    return end_s


async def _write(store: Store, pieces: list[Piece]) -> None:
    async with store.write() as work:
        for piece in pieces:
            await work.recordings.add(piece)
