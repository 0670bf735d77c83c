"""Benchmark `sim`: how much faster than real time whole factories run on one core, at three sizes.

Every size runs in a process of its own, so that its memory is its own too. The baseline is the cost of the same
number of events without decisions: a heap of timed calls, and the calls.
"""

from __future__ import annotations

import asyncio
import heapq
import multiprocessing
import resource
import time
from collections.abc import Iterable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from itertools import count
from random import Random

from dray.plant import Plant, default_plant
from dray_sim.bench.row import Row
from dray_sim.clock.loop import clock, run
from dray_sim.factory.sim_factory import SimFactory
from dray_sim.people import demand
from dray_sim.people.order_client import OrderClient
from dray_sim.plants.generator import generate_plant

SEED = 1
LOAD = 0.85
"""The load of the scenario `day`."""

WARM_UP_S = 600.0
"""Virtual time before the clock is taken: orders have come, goals are made, transports run."""

SPAN_S = 3600.0
QUICK_SPAN_S = 300.0

TARGET = 500.0
"""A shift of eight hours in a minute, at 50 ATVs."""


@dataclass(frozen=True, slots=True)
class Size:
    """One plant to measure: the default one, or one generated at equal density."""

    atvs: int
    machines: int
    default: bool = False
    target: float | None = None

    def plant(self) -> Plant:
        return default_plant() if self.default else generate_plant(SEED, self.machines, self.atvs)


SIZES = (
    Size(atvs=8, machines=12, default=True),
    Size(atvs=50, machines=20, target=TARGET),
    Size(atvs=200, machines=80),
)


@dataclass(frozen=True, slots=True)
class Measured:
    """The cost of one run.

    Attributes:
        speed: virtual seconds per real second.
        events: events that agents handled.
        messages: deliveries on the bus.
        memory_mb: the most that the process ever held.
    """

    speed: float
    bare_speed: float
    real_s: float
    events: int
    messages: int
    memory_mb: float


def measure(quick: bool, traffic: bool = False) -> list[Row]:
    """Measure the whole simulation.

    Args:
        quick: a twelfth of the time.
        traffic: whether vehicles drive with right of way.
    """
    span_s = QUICK_SPAN_S if quick else SPAN_S
    return [_row(size, _alone(size, span_s, traffic)) for size in SIZES]


def _row(size: Size, measured: Measured) -> Row:
    return Row(
        f"sim: {size.atvs} ATVs, {size.machines} machines",
        measured.speed,
        "x real time",
        measured.bare_speed,
        "as many bare timed calls",
        size.target,
        note=(
            f"{measured.events / measured.real_s:,.0f} events/s, "
            f"{measured.messages / measured.real_s:,.0f} messages/s, {measured.memory_mb:.0f} MB"
        ),
    )


def _alone(size: Size, span_s: float, traffic: bool) -> Measured:
    """Run one size in a fresh process."""
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(max_workers=1, mp_context=context) as pool:
        return pool.submit(run_size, size, span_s, traffic).result()


def run_size(size: Size, span_s: float, traffic: bool) -> Measured:
    """Run one size in this process."""
    return run(_play(size.plant(), span_s, traffic))


async def _play(plant: Plant, span_s: float, traffic: bool) -> Measured:
    factory = SimFactory(plant, clock(), seed=SEED, traffic=traffic)
    until_s = WARM_UP_S + span_s
    orders = demand.orders(plant, Random(SEED), load=LOAD, until_s=until_s)
    life = asyncio.create_task(_live(factory, orders))
    await asyncio.wait({life}, timeout=WARM_UP_S)
    events, messages = _events(factory), factory.bus.delivered
    start_s = time.perf_counter()
    await asyncio.wait({life}, timeout=span_s)
    real_s = time.perf_counter() - start_s
    if life.done():
        life.result()
        raise RuntimeError("the factory has come to an end while it was measured")
    events, messages = _events(factory) - events, factory.bus.delivered - messages
    life.cancel()
    await asyncio.gather(life, return_exceptions=True)
    return Measured(
        speed=span_s / real_s,
        bare_speed=span_s / _bare_s(events, pending=4 * len(factory.workers)),
        real_s=real_s,
        events=events,
        messages=messages,
        memory_mb=resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0,
    )


async def _live(factory: SimFactory, orders: Iterable[demand.Order]) -> None:
    async with asyncio.TaskGroup() as group:
        group.create_task(factory.run())
        group.create_task(OrderClient(factory.bus, factory.clock).place(orders))


def _events(factory: SimFactory) -> int:
    return sum(worker.handled for worker in factory.workers.values())


def _bare_s(calls: int, pending: int) -> float:
    """Real seconds for as many timed calls that do nothing."""
    numbers, random = count(), Random(SEED)
    heap = [(random.random(), next(numbers), _nothing) for _ in range(pending)]
    heapq.heapify(heap)
    start_s = time.perf_counter()
    for _ in range(calls):
        when_s, _, call = heapq.heappop(heap)
        call()
        heapq.heappush(heap, (when_s + random.random(), next(numbers), call))
    return time.perf_counter() - start_s


def _nothing() -> None:
    """An event without any decision."""
