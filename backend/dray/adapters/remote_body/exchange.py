"""An exchange between two sides over an unreliable channel: every part is received once, and in order.

Each side numbers its parts and keeps them until the other confirms them. A letter carries all unconfirmed parts, and the
number of the last part received. This module uses no clock: a side writes again when a letter tells it nothing new, or when it
has unconfirmed parts. A lost letter therefore does no harm.
"""

from __future__ import annotations

import msgspec

from dray.errors import ProtocolViolation

Part = tuple[str, msgspec.Raw]
"""A part's type name, and its content."""

PARTS_PER_LETTER = 50
"""Maximum parts in a letter, far more than usually wait; the rest goes into the next one."""

KEPT_MAX = 1000
"""Maximum unconfirmed parts: a side that lacks so many is dead or cut off. Parts cannot be skipped, so a writer with more
gives up the connection."""


class Letter(msgspec.Struct, array_like=True, frozen=True):
    """One message of the exchange.

    Attributes:
        heard: number of the last part received by the writer.
        first: number of the first of `parts`, from 1 on.
        parts: the parts in their order.
    """

    heard: int
    first: int
    parts: tuple[Part, ...] = ()


class Exchange:
    """One side of an exchange.

    Attributes:
        heard: number of parts received.
        again: number of parts written more than once.
    """

    def __init__(self) -> None:
        self.heard = 0
        self.again = 0
        self._first = 1
        self._kept: list[Part] = []
        self._written = 0
        """Number of the last part written."""
        self._repeated = False

    @property
    def said(self) -> int:
        """Number of parts said."""
        return self._first - 1 + len(self._kept)

    @property
    def kept(self) -> int:
        """Number of unconfirmed parts."""
        return len(self._kept)

    @property
    def full(self) -> bool:
        """Whether the maximum of unconfirmed parts is reached."""
        return len(self._kept) >= KEPT_MAX

    @property
    def due(self) -> bool:
        """Whether a letter must be written: a part or a confirmation is open."""
        return self._repeated or bool(self._kept)

    def say(self, part: Part) -> None:
        """Add a part, and keep it until the other side confirms it.

        Raises:
            ProtocolViolation: the exchange is full.
        """
        if self.full:
            raise ProtocolViolation(f"{KEPT_MAX} parts are not heard yet; let go of the other side")
        self._kept.append(part)

    def write(self) -> Letter:
        """The next letter to the other side."""
        self._repeated = False
        parts = tuple(self._kept[:PARTS_PER_LETTER])
        last = self._first + len(parts) - 1
        self.again += max(0, min(last, self._written) - self._first + 1)
        self._written = max(last, self._written)
        return Letter(self.heard, self._first, parts)

    def read(self, letter: Letter) -> tuple[Part, ...]:
        """The new parts of a letter."""
        known = letter.heard + 1 - self._first
        if known > 0:
            del self._kept[:known]
            self._first += known
        old = self.heard + 1 - letter.first
        if old < 0:
            return ()  # Parts in between are lost; the writer keeps them.
        new = letter.parts[old:]
        self._repeated |= bool(letter.parts[:old])
        self.heard += len(new)
        return new
