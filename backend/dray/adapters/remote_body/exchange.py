"""An exchange between two sides over a way that loses, doubles and delays: what is said is heard once, and in order.

Each side numbers what it says and keeps it until the other has heard it. A letter carries everything that is
kept, and how far its writer has heard the other. Nothing here looks at a clock: whoever gets a letter that tells
nothing new, or has something kept, writes again. A letter that is lost is therefore no loss.
"""

from __future__ import annotations

import msgspec

from dray.errors import ProtocolViolation

Part = tuple[str, msgspec.Raw]
"""What is said, and of which kind it is."""

PARTS_PER_LETTER = 50
"""Far more than wait where letters arrive; the rest is in the next one."""

KEPT_MAX = 1000
"""Parts that wait to be heard: a side that lacks so many is dead or cut off. What it lacks cannot be left out, so
whoever has more to say lets go of it."""


class Letter(msgspec.Struct, array_like=True, frozen=True):
    """What one side says.

    Attributes:
        heard: number of the last part that its writer has heard.
        first: number of the first of `parts`, from 1 on.
        parts: in the order in which they were said.
    """

    heard: int
    first: int
    parts: tuple[Part, ...] = ()


class Exchange:
    """One side of it.

    Attributes:
        heard: how many parts of the other side have been heard.
        again: how often a part was written that had been written before.
    """

    def __init__(self) -> None:
        self.heard = 0
        self.again = 0
        self._first = 1
        self._kept: list[Part] = []
        self._written = 0
        """Number of the last part that was written."""
        self._repeated = False

    @property
    def said(self) -> int:
        """How many parts were said."""
        return self._first - 1 + len(self._kept)

    @property
    def kept(self) -> int:
        """How many parts the other side has not heard yet, as far as is known here."""
        return len(self._kept)

    @property
    def full(self) -> bool:
        """Whether so many parts are kept that no more may be said."""
        return len(self._kept) >= KEPT_MAX

    @property
    def due(self) -> bool:
        """Whether a letter is to be written: the other side lacks something, or does not know that we have heard it."""
        return self._repeated or bool(self._kept)

    def say(self, part: Part) -> None:
        """Keep this until the other side has heard it.

        Raises:
            ProtocolViolation: it is full.
        """
        if self.full:
            raise ProtocolViolation(f"{KEPT_MAX} parts are not heard yet; let go of the other side")
        self._kept.append(part)

    def write(self) -> Letter:
        """What the other side is to get now."""
        self._repeated = False
        parts = tuple(self._kept[:PARTS_PER_LETTER])
        last = self._first + len(parts) - 1
        self.again += max(0, min(last, self._written) - self._first + 1)
        self._written = max(last, self._written)
        return Letter(self.heard, self._first, parts)

    def read(self, letter: Letter) -> tuple[Part, ...]:
        """What is new in a letter."""
        known = letter.heard + 1 - self._first
        if known > 0:
            del self._kept[:known]
            self._first += known
        old = self.heard + 1 - letter.first
        if old < 0:
            return ()  # What is between has been lost; its writer keeps it.
        new = letter.parts[old:]
        self._repeated |= bool(letter.parts[:old])
        self.heard += len(new)
        return new
