"""A supervisor: tasks that serve others go on, whatever one message makes of them.

What fails is our own bug: it is said at ERROR with where it was, counted, and the task is started again. It waits longer each time, so that
one that fails at once does not keep the processor busy. A task that has one message at a time in hand need not end at all: it counts the
failure (`Failures`) and takes the next message. A task that looks from time to time (`keep_looking`) goes on when the database is away.
"""

from __future__ import annotations

import asyncio
import logging
import threading
from collections import Counter
from collections.abc import Awaitable, Callable

from dray.errors import UnavailableError

FIRST_S, MOST_S = 1.0, 60.0
"""A task that has failed is started again after this, doubled each time. One that has run for the longest is new again."""

_log = logging.getLogger(__name__)


class Supervisor:
    """Of the tasks of one process.

    Attributes:
        restarts: task -> how often it has failed and was started again.
    """

    def __init__(self) -> None:
        self.restarts: Counter[str] = Counter()

    async def keep(self, name: str, run: Callable[[], Awaitable[None]]) -> None:
        """Run a task until it ends by itself or is cancelled.

        Args:
            name: of the task, in metrics and logs.
            run: begins it; called again after each failure, and goes on with what it finds.
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
    """Look from time to time, until cancelled; what is away now is there at a later look.

    Args:
        look: one look.
        every_s: wall seconds between the end of one and the next.
        away: told why a look could not be done.
        at_once: the first look does not wait.
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
    """Messages that could not be dealt with, by our own fault: counted, and said at ERROR. From any thread.

    The first failure of each kind is said with where it was, and then each time that their number has doubled: a peer that says the same ten times a
    second does not fill the log.

    Args:
        whose: they are, for the log.

    Attributes:
        counts: kind of message -> how many have failed. Kinds are few and fixed.
    """

    def __init__(self, whose: str) -> None:
        self._whose = whose
        self._lock = threading.Lock()
        self.counts: Counter[str] = Counter()

    @property
    def total(self) -> int:
        """How many have failed, of all kinds."""
        return self.counts.total()

    def tell(self, kind: str, listener: Callable[..., None], *args: object) -> None:
        """Tell a listener something; what one message makes of it ends nothing.

        Raises:
            UnavailableError: the listener has: without its disk, say, it could promise nothing.
        """
        try:
            listener(*args)
        except UnavailableError:
            raise
        except Exception:  # noqa: BLE001 - whatever it is, it is about this one message
            self.note(kind)

    def note(self, kind: str) -> None:
        """Count the exception that is being handled, and say it."""
        with self._lock:
            self.counts[kind] += 1
            count = self.counts[kind]
        if count & (count - 1) == 0:
            _log.exception(
                "%s: %s has failed, %d times so far; the next one is served", self._whose, kind, count
            )
