"""Many plants or fleets, one after the other or in several processes."""

from __future__ import annotations

import multiprocessing
import signal
from collections.abc import Callable, Container, Generator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from functools import partial
from typing import TypeVar

from dray.errors import UnavailableError
from dray_sim.plants.play import HOURS, Judgement, Kind, play_seed
from dray_sim.run.workers import end_with_parent

A = TypeVar("A")
R = TypeVar("R")


def _begin() -> None:
    """Prepare a process of the pool: Ctrl-C ends it at once and without a traceback, since its plant is played again."""
    end_with_parent()
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def play_seeds(
    first: int,
    count: int,
    kind: Kind = "raster",
    *,
    small: bool = False,
    hours: float = HOURS,
    traffic: bool = False,
    jobs: int = 1,
    left_out: Container[int] = (),
    at_once: bool = False,
) -> Generator[Judgement, None, None]:
    """Play the plants of so many seeds.

    Args:
        first: the first seed.
        count: how many.
        kind: of plants.
        small: few machines and vehicles each.
        hours: of demand.
        traffic: whether vehicles drive with right of way.
        jobs: processes; 1 plays them in this one.
        left_out: seeds that are not played.
        at_once: yield each judgement as soon as its plant has worked; else in the order of the seeds.

    Raises:
        UnavailableError: a process was killed from outside.
    """
    play = partial(play_seed, kind=kind, small=small, hours=hours, traffic=traffic)
    seeds = [seed for seed in range(first, first + count) if seed not in left_out]
    return play_each(play, seeds, jobs=jobs, at_once=at_once)


def play_each(
    play: Callable[[A], R], asked: Sequence[A], *, jobs: int = 1, at_once: bool = False
) -> Generator[R, None, None]:
    """Call a function with each of several arguments, in so many processes.

    Args:
        play: makes one run.
        asked: its arguments.
        jobs: processes; 1 plays in this one, as does a single run.
        at_once: yield each result as soon as it is there; else in the order of the arguments.

    Raises:
        UnavailableError: a process was killed from outside.
    """
    if jobs == 1 or len(asked) == 1:
        yield from map(play, asked)
        return
    context = multiprocessing.get_context("spawn")
    pool = ProcessPoolExecutor(jobs, mp_context=context, initializer=_begin)
    try:
        futures = [pool.submit(play, each) for each in asked]
        for future in as_completed(futures) if at_once else futures:
            yield future.result()
    except BrokenProcessPool:
        remedy = "see whether memory ran out, and give fewer --jobs"
        raise UnavailableError("the search", "one of its processes was killed", remedy) from None
    finally:
        pool.shutdown(cancel_futures=True)
