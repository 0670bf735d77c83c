"""The wall clock of a gateway under test."""

from __future__ import annotations

from dataclasses import dataclass

NOW_S = 1_900_000_000.0
"""The wall clock at the start: 17 March 2030."""


@dataclass
class Wall:
    """A wall clock that goes when it is told to."""

    now_s: float = NOW_S

    def __call__(self) -> float:
        return self.now_s
