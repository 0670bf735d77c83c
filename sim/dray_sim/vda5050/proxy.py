"""A proxy between agents and vehicles: it drops, doubles, delays, spoils and reorders messages."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable
from contextlib import suppress
from random import Random

from dray.ports import Clock

DELAY_S = 0.02
"""Transit time of an undisturbed message."""

DROP, DOUBLE, LATE, SPOIL = 0.05, 0.05, 0.10, 0.03
"""Probability of each disturbance of a message."""

LATEST_S = 2.0
"""Longest delay of a late message, which may come after later ones: reordered."""


class Proxy:
    """Carries the messages of all vehicles of a factory, in both directions; carriers may be down.

    Args:
        clock: the plant's.
        chance: of the disturbances.

    Attributes:
        did: number of each disturbance.
        down: vehicles whose broker is away: their messages are lost.
        quiet: messages are not disturbed any more.
    """

    def __init__(self, clock: Clock, chance: Random) -> None:
        self._clock, self._chance = clock, chance
        self.did: Counter[str] = Counter()
        self.down: set[str] = set()
        self.quiet = False

    def carry(self, atv: str, data: bytes, hand: Callable[[bytes], None]) -> None:
        """Carry a message, with its disturbance.

        Args:
            atv: whose broker it passes.
            data: the message.
            hand: delivers it.
        """
        self.did["carried"] += 1
        if atv in self.down:
            self.did["lost with a broker"] += 1
            return
        if self.quiet:
            self._later(DELAY_S, atv, data, hand)
            return
        if self._befalls("dropped", DROP):
            return
        if self._befalls("spoilt", SPOIL):
            data = self._spoilt(data)
        delay_s = DELAY_S
        if self._befalls("delayed", LATE):
            delay_s = self._chance.uniform(DELAY_S, LATEST_S)
        self._later(delay_s, atv, data, hand)
        if self._befalls("doubled", DOUBLE):
            self._later(self._chance.uniform(DELAY_S, LATEST_S), atv, data, hand)

    def _befalls(self, what: str, frac: float) -> bool:
        befalls = self._chance.random() < frac
        self.did[what] += befalls
        return befalls

    def _later(self, delay_s: float, atv: str, data: bytes, hand: Callable[[bytes], None]) -> None:
        def arrive() -> None:
            if atv not in self.down:
                hand(data)

        self._clock.call_at(self._clock.now_s() + delay_s, arrive)

    def _spoilt(self, data: bytes) -> bytes:
        """Cut short, or with bytes that are none of a text; never another message that can be read."""
        at = self._chance.randrange(len(data)) if data else 0
        spoilt = data[:at] if self._chance.random() < 0.5 else data[:at] + b"\xff\x00" + data[at + 2 :]
        with suppress(ValueError):
            json.loads(spoilt)
            return spoilt + b"\xff"
        return spoilt
