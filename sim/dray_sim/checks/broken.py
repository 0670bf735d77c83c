"""The error that says which invariant was broken, when, and by what."""

from __future__ import annotations

from dray.errors import DrayError


class InvariantBroken(DrayError):
    """Something was seen that the protocol excludes.

    Attributes:
        number: of the invariant in protocol.md.
        at_s: when it was seen (plant clock).
        seen: what.
    """

    def __init__(self, number: int, at_s: float, seen: str) -> None:
        self.number, self.at_s, self.seen = number, at_s, seen
        super().__init__(f"invariant {number} is broken at {at_s:.3f} s: {seen}")

    def __reduce__(self) -> tuple[type[InvariantBroken], tuple[int, float, str]]:
        """From process to process as it was made: from its parts, not from its message."""
        return type(self), (self.number, self.at_s, self.seen)
