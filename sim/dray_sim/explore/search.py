"""Many runs, in as many processes as are wanted, and their results.

Outcomes come in the order of their seeds, for any number of processes. A search that is stopped sums up its results
so far; with a ledger, the next one goes on.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import time
from collections import Counter, deque
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import closing, contextmanager
from functools import partial
from itertools import islice
from multiprocessing.synchronize import Event

from dray.errors import UnavailableError
from dray_sim.explore.ledger import Entry, Ledger
from dray_sim.explore.outcome import Outcome, Summary
from dray_sim.explore.play import try_seed
from dray_sim.run.workers import end_with_parent

CHUNK = 8
"""Seeds that a process plays in one go: they take some seconds, long compared with the cost of a message."""

AHEAD = 3
"""Chunks per process that wait or run: enough that none idles, few enough that a stop is quick."""

TOLD = 20
"""Violations that are kept with their stories."""

Tries = Callable[[int], tuple[Outcome, float]]
"""Plays a seed."""

Played = list[tuple[Outcome, float]]
"""Outcomes, and the processor time that each took (s)."""

_stop: Event | None = None
"""In a process of the pool: set when it should play no further seed."""


def search(
    first: int,
    last: int,
    *,
    profile: str = "all",
    traffic: bool = False,
    jobs: int = 1,
    progress: Callable[[Outcome], None] = lambda _outcome: None,
    ledger: Ledger | None = None,
) -> Summary:
    """Try the seeds from `first` to before `last`.

    Args:
        first: the first one.
        last: the one after the last one.
        profile: a name in `dray_sim.explore.profile.PROFILES`.
        traffic: whether vehicles drive with right of way.
        jobs: processes; 1 plays them in this one.
        progress: called with every outcome, in the order of seeds.
        ledger: has the seeds that were played before, which count and are not played again; gets every new one.

    Returns:
        The summary; after a KeyboardInterrupt or SIGTERM, that of the results so far.

    Raises:
        SettingsError: the ledger's file is something else.
        UnavailableError: a process was killed from outside, or the ledger cannot be read or written.
    """
    tally = _Tally(first, last, profile, jobs)
    before: Mapping[int, Entry] = {}
    if ledger is not None:
        ledger.begin()
        before = ledger.played(profile, traffic=traffic)
    tries = partial(_timed, profile=profile, traffic=traffic, ledger=ledger)
    seeds = (seed for seed in range(first, last) if seed not in before)
    played = _play_here(seeds, tries) if jobs == 1 else _play_in_pool(seeds, tries, jobs)
    with _stoppable(), closing(played):
        try:
            for seed in range(first, last):
                entry = before.get(seed)
                outcome, took_s = next(played) if entry is None else (entry.outcome, entry.took_s)
                tally.add(outcome, took_s, is_new=entry is None)
                progress(outcome)
        except KeyboardInterrupt:
            tally.interrupted = True
            # The pool ends within seconds; a second Ctrl-C in its midst would leave processes behind.
            signal.signal(signal.SIGINT, signal.SIG_IGN)
    return tally.summary()


@contextmanager
def _stoppable() -> Iterator[None]:
    """Let a SIGTERM stop the search like Ctrl-C: no result is lost, and no process of the pool is left behind."""
    before = {stop: signal.getsignal(stop) for stop in (signal.SIGTERM, signal.SIGINT)}
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        yield
    finally:
        for stop, handler in before.items():
            signal.signal(stop, handler)


class _Tally:
    """The sums of a search."""

    def __init__(self, first: int, last: int, profile: str, jobs: int) -> None:
        self.interrupted = False
        self._asked = (first, last, profile, jobs)
        self._runs = self._before = self._broken = 0
        self._violations: list[Outcome] = []
        self._virtual_s = self._busy_s = 0.0
        self._counts: Counter[str] = Counter()
        self._faults: Counter[str] = Counter()

    def add(self, outcome: Outcome, took_s: float, *, is_new: bool) -> None:
        self._runs += 1
        self._before += not is_new
        self._virtual_s += outcome.duration_s
        self._busy_s += took_s
        for name in ("transports", "takeovers", "restarts", "messages"):
            self._counts[name] += getattr(outcome, name)
        self._faults.update(outcome.faults)
        if outcome.broken:
            self._broken += 1
            if len(self._violations) < TOLD:
                self._violations.append(outcome)

    def summary(self) -> Summary:
        first, last, profile, jobs = self._asked
        return Summary(
            first=first,
            last=last,
            profile=profile,
            runs=self._runs,
            before=self._before,
            interrupted=self.interrupted,
            violations=tuple(self._violations),
            broken=self._broken,
            virtual_s=self._virtual_s,
            busy_s=self._busy_s,
            jobs=jobs,
            transports=self._counts["transports"],
            takeovers=self._counts["takeovers"],
            restarts=self._counts["restarts"],
            messages=self._counts["messages"],
            faults=dict(sorted(self._faults.items())),
        )


def _play_here(seeds: Iterable[int], tries: Tries) -> Generator[tuple[Outcome, float], None, None]:
    for seed in seeds:
        yield tries(seed)


def _play_in_pool(
    seeds: Iterator[int], tries: Tries, jobs: int
) -> Generator[tuple[Outcome, float], None, None]:
    # Spawned, not forked: every process begins alike, on every system.
    context = multiprocessing.get_context("spawn")
    stop = context.Event()
    running: deque[Future[Played]] = deque()
    pool = ProcessPoolExecutor(jobs, mp_context=context, initializer=_begin, initargs=(stop,))
    try:
        while True:
            while len(running) < AHEAD * jobs and (chunk := tuple(islice(seeds, CHUNK))):
                running.append(pool.submit(_play_chunk, chunk, tries))
            if not running:
                return
            yield from running.popleft().result()
    except BrokenProcessPool:
        remedy = "see whether memory ran out, and give fewer --jobs"
        raise UnavailableError("the search", "one of its processes was killed", remedy) from None
    finally:
        stop.set()
        pool.shutdown(cancel_futures=True)


def _begin(stop: Event) -> None:
    """Prepare a process of the pool."""
    global _stop  # noqa: PLW0603 (a pool hands nothing else to its processes)
    _stop = stop
    end_with_parent()
    # Ctrl-C reaches the whole process group; the parent alone decides how to react.
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def _play_chunk(seeds: Iterable[int], tries: Tries) -> Played:
    played: Played = []
    for seed in seeds:
        if _stop is not None and _stop.is_set():
            break
        played.append(tries(seed))
    return played


def _timed(seed: int, profile: str, *, traffic: bool, ledger: Ledger | None) -> tuple[Outcome, float]:
    """The outcome and its processor time, which does not depend on other load; kept in the ledger at once."""
    began_s = time.process_time()
    outcome = try_seed(seed, profile, traffic=traffic)
    took_s = time.process_time() - began_s
    if ledger is not None:
        ledger.add(outcome, took_s)
    return outcome, took_s


def cores() -> int:
    """Number of processes that this machine can run at once."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
