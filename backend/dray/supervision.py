"""A supervisor: serving tasks continue, whatever error one message causes.

A failure is our own bug. The supervisor logs it at ERROR with its traceback, counts it, and restarts the task. The delay grows each
time, so that a task that fails at once does not load the processor. A task that handles one message at a time need not end: it
counts the failure (`Failures`) and takes the next message. A periodic task (`keep_looking`) continues while the database is away.
"""

from __future__ import annotations

import asyncio
import logging
import threading
from collections import Counter
from collections.abc import Awaitable, Callable

from dray.errors import UnavailableError

FIRST_S, MOST_S = 1.0, 60.0
"""Seconds before the first restart, doubled up to the second value. A task that has run for the latter counts as new."""

_log = logging.getLogger(__name__)


class Supervisor:
    """Restarts the tasks of one process.

    Attributes:
        restarts: task -> number of restarts after failures.
    """

    def __init__(self) -> None:
        self.restarts: Counter[str] = Counter()

    async def keep(self, name: str, run: Callable[[], Awaitable[None]]) -> None:
        """Run a task until it ends by itself or is cancelled.

        Args:
            name: the task's name, in metrics and logs.
            run: the task; called again after each failure, and continues from the present state.
        """
        clock, wait_s = asyncio.get_running_loop(), FIRST_S
        self.restarts[name] += 0
        while True:
            begun_s = clock.time()
            try:
                await run()
            except Exception:  # noqa: BLE001 - whatever it is, the task goes on
                if clock.time() - begun_s >= MOST_S:
                    wait_s = FIRST_S
                self.restarts[name] += 1
                _log.exception("%s has failed; it is started again in %g s", name, wait_s)
            else:
                return
            await asyncio.sleep(wait_s)
            wait_s = min(2.0 * wait_s, MOST_S)


async def keep_looking(
    look: Callable[[], Awaitable[object]],
    every_s: float,
    away: Callable[[UnavailableError], None],
    *,
    at_once: bool = False,
) -> None:
    """Look periodically, until cancelled; a later look retries after an outage.

    Args:
        look: one look.
        every_s: wall seconds between the end of one look and the next.
        away: called with the reason why a look failed.
        at_once: whether the first look happens without a delay.
    """
    if not at_once:
        await asyncio.sleep(every_s)
    while True:
        try:
            await look()
        except UnavailableError as error:
            away(error)
        await asyncio.sleep(every_s)


class Failures:
    """Messages whose handling failed by our own fault: counted, and logged at ERROR. Thread-safe.

    The first failure of each kind is logged with its traceback. Later it is logged whenever the count has doubled, so that ten
    equal messages a second do not fill the log.

    Args:
        whose: the owner of the messages, for the log.

    Attributes:
        counts: kind of message -> number of failures. Kinds are few and fixed.
    """

    def __init__(self, whose: str) -> None:
        self._whose = whose
        self._lock = threading.Lock()
        self.counts: Counter[str] = Counter()

    @property
    def total(self) -> int:
        """The number of failures of all kinds."""
        return self.counts.total()

    def tell(self, kind: str, listener: Callable[..., None], *args: object) -> None:
        """Call a listener; an error in handling one message ends nothing.

        Raises:
            UnavailableError: raised by the listener: without its disk, say, it could promise nothing.
        """
        try:
            listener(*args)
        except UnavailableError:
            raise
        except Exception:  # noqa: BLE001 - whatever it is, it is about this one message
            self.note(kind)

    def note(self, kind: str) -> None:
        """Count and log the exception being handled."""
        with self._lock:
            self.counts[kind] += 1
            count = self.counts[kind]
        if count & (count - 1) == 0:
            _log.exception(
                "%s: %s has failed, %d times so far; the next one is served", self._whose, kind, count
            )
