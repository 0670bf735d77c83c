"""Shares: how much one agent may say to another one, so that one that never stops talking costs the others next to nothing."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

from dray.adapters.zenoh.stamp import Stamp, Tally
from dray.messages.kinds import Kind

SAID_PER_S = 100.0
"""Messages that one agent may say to another one, by the plant's clock. The most that was seen in a second of a small fleet, start and attack
included, is 7 of a vehicle, 34 of a machine, and 60 of a station that keeps a book."""

AT_ONCE_S = 10.0
"""Real seconds of it that may be said at once: what a link that was away has kept back."""

TALKATIVE = "more than one agent may say"


class ShareSpentError(Exception):
    """A message came in from an agent that has said all that it may."""


UNBOUNDED = frozenset({Kind.STRATEGIST, Kind.GATEWAY})
"""They speak for thousands of orders, and are the plant's own software."""


class Shares:
    """What one agent hears of each of the others, on the threads on which messages come in.

    Only what an agent has signed counts as its own, and what is said again (whoever says it again) has a share of its own: so nobody can
    use up what another one has to say. Once a share is spent, all that comes in that name is refused unexamined.

    Args:
        tally: which numbers were heard.
        speed: seconds of the plant's clock per second.
        now_s: real time that never goes back; for tests.
    """

    def __init__(self, tally: Tally, speed: float = 1.0, now_s: Callable[[], float] = time.monotonic) -> None:
        self._tally = tally
        self._per_s = SAID_PER_S * speed
        self._now_s = now_s
        self._lock = threading.Lock()
        self._free_s: dict[str, float] = {}
        """Share -> when all of what it has said has been its due. Only certificates make one, so they are few."""

    def check(self, speaker: str, key: str, stamp: Stamp) -> None:
        """Look whether it may say this now.

        Raises:
            ShareSpentError: it must be silent for a while.
        """
        free_s = self._free_s.get(self._share(speaker, key, stamp))
        if free_s is not None and free_s - self._now_s() > AT_ONCE_S:
            raise ShareSpentError

    def note(self, speaker: str, key: str, stamp: Stamp, kind: Kind | None) -> None:
        """It has said something, as its signature shows; kind None where there are no signatures, and nobody is known."""
        if kind is None or kind in UNBOUNDED:
            return
        share = self._share(speaker, key, stamp)
        with self._lock:
            self._free_s[share] = max(self._free_s.get(share, 0.0), self._now_s()) + 1.0 / self._per_s

    def _share(self, speaker: str, key: str, stamp: Stamp) -> str:
        # No name holds a space.
        return speaker if self._tally.is_news(speaker, key, stamp) else f"{speaker} again"
