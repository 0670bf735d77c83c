"""Shares: a limit of one agent's messages to another one, so that an agent that never stops talking costs the others little."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

from dray.adapters.zenoh.stamp import Stamp, Tally
from dray.messages.kinds import Kind

SAID_PER_S = 100.0
"""Maximum rate of messages from one agent to another one, by the plant's clock. The maximum in a small fleet, with
its start and an attack, was 7 for a vehicle, 34 for a machine, and 60 for a station with a reservation table."""

AT_ONCE_S = 10.0
"""Real seconds of the rate that may come at once: a backlog after a link's outage."""

TALKATIVE = "more than one agent may say"


class ShareSpentError(Exception):
    """A message has come from an agent that has used up its share."""


UNBOUNDED = frozenset({Kind.STRATEGIST, Kind.GATEWAY})
"""Kinds without a limit: they speak for thousands of orders, and are the plant's own software."""


class Shares:
    """One agent's limits for each of the others, on the threads of incoming messages.

    Only messages that an agent has signed count for it, and replays by any process have a separate share. So nobody can use up
    another agent's share. Once a share is spent, all messages in that name are refused without verification.

    Args:
        tally: the received numbers.
        speed: seconds of the plant's clock per second.
        now_s: monotonic real time; for tests.
    """

    def __init__(self, tally: Tally, speed: float = 1.0, now_s: Callable[[], float] = time.monotonic) -> None:
        self._tally = tally
        self._per_s = SAID_PER_S * speed
        self._now_s = now_s
        self._lock = threading.Lock()
        self._free_s: dict[str, float] = {}
        """Share -> the time at which its messages are within the rate again. Only certificates create one, so they are few."""

    def check(self, speaker: str, key: str, stamp: Stamp) -> None:
        """Check whether the sender may send now.

        Raises:
            ShareSpentError: it must pause.
        """
        free_s = self._free_s.get(self._share(speaker, key, stamp))
        if free_s is not None and free_s - self._now_s() > AT_ONCE_S:
            raise ShareSpentError

    def note(self, speaker: str, key: str, stamp: Stamp, kind: Kind | None) -> None:
        """Count a message with a verified sender; kind is None without signatures, and then nobody is limited."""
        if kind is None or kind in UNBOUNDED:
            return
        share = self._share(speaker, key, stamp)
        with self._lock:
            self._free_s[share] = max(self._free_s.get(share, 0.0), self._now_s()) + 1.0 / self._per_s

    def _share(self, speaker: str, key: str, stamp: Stamp) -> str:
        # No name contains a space.
        return speaker if self._tally.is_news(speaker, key, stamp) else f"{speaker} again"
