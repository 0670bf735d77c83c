"""Two vehicles or programs that send under one name: their states come by turns, each with its own place and its own numbers.

A vehicle that is restarted counts from the beginning, and localisation may jump. Neither goes to and fro, again and again.
"""

from __future__ import annotations

from collections import deque

TURNS = 3
"""Turns within `WITHIN_S` that mean two senders."""

WITHIN_S = 70.0
"""States come every 30 s at least, and two of one sender may follow one another."""


class Senders:
    """The senders of one vehicle's states."""

    def __init__(self) -> None:
        self._turns_s: deque[float] = deque(maxlen=TURNS)
        self._two_until_s = 0.0

    def note(self, now_s: float) -> None:
        """A state counts far back, after one whose place the vehicle cannot have reached."""
        self._turns_s.append(now_s)
        if self.are_two(now_s) or (len(self._turns_s) == TURNS and now_s - self._turns_s[0] <= WITHIN_S):
            self._two_until_s = now_s + WITHIN_S

    def are_two(self, now_s: float) -> bool:
        """Whether there are two now; until they were not seen for a while."""
        return now_s < self._two_until_s
