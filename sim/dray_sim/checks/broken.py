"""The error for a broken invariant, with its time and its cause."""

from __future__ import annotations

from dray.errors import DrayError


class InvariantBroken(DrayError):
    """Something was seen that the protocol excludes.

    Attributes:
        number: of the invariant in protocol.md.
        at_s: when it was seen (plant clock).
        seen: the observation.
    """

    def __init__(self, number: int, at_s: float, seen: str) -> None:
        self.number, self.at_s, self.seen = number, at_s, seen
        super().__init__(f"invariant {number} is broken at {at_s:.3f} s: {seen}")

    def __reduce__(self) -> tuple[type[InvariantBroken], tuple[int, float, str]]:
        """Pickle it from its parts and not from its message, to send it between processes."""
        return type(self), (self.number, self.at_s, self.seen)
