"""Many plants, one after the other or in several processes, judged in the order of their seeds."""

from __future__ import annotations

import multiprocessing
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from functools import partial

from dray.errors import UnavailableError
from dray_sim.plants.play import HOURS, Judgement, Kind, play_seed
from dray_sim.run.workers import end_with_parent


def play_seeds(
    first: int,
    count: int,
    kind: Kind = "raster",
    *,
    small: bool = False,
    hours: float = HOURS,
    traffic: bool = False,
    jobs: int = 1,
) -> Iterator[Judgement]:
    """Play the plants of so many seeds.

    Args:
        first: the first seed.
        count: how many.
        kind: of plants.
        small: few machines and vehicles each.
        hours: of demand.
        traffic: whether vehicles drive with right of way.
        jobs: processes; 1 plays them in this one.

    Raises:
        UnavailableError: a process was killed from outside.
    """
    play = partial(play_seed, kind=kind, small=small, hours=hours, traffic=traffic)
    seeds = range(first, first + count)
    if jobs == 1:
        yield from map(play, seeds)
        return
    context = multiprocessing.get_context("spawn")
    pool = ProcessPoolExecutor(jobs, mp_context=context, initializer=end_with_parent)
    try:
        yield from pool.map(play, seeds)
    except BrokenProcessPool:
        remedy = "see whether memory ran out, and give fewer --jobs"
        raise UnavailableError("the search", "one of its processes was killed", remedy) from None
    finally:
        pool.shutdown(cancel_futures=True)
