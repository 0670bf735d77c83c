"""Orders that end before the vehicle has driven: it accepts each, and each is over where it began.

One such order may have its reason, as a node that cannot be reached. Several without any driving are a problem of the vehicle: its agent
would order for ever, and nobody would be told. The problem ends by itself, since only another order shows whether the vehicle drives again;
it lasts twice as long each time.
"""

from __future__ import annotations

ORDERS = 3

TOLD_S, TOLD_MAX_S = 60.0, 600.0
"""Duration of the problem: at first, and at most."""


class UndrivenOrders:
    """Counts the consecutive orders of one vehicle that ended without driving."""

    def __init__(self) -> None:
        self._ended = 0
        self._why = ""
        self._told_s, self._until_s = TOLD_S, 0.0

    def ended(self, why: str, now_s: float) -> None:
        """An order has ended where it began, with the reason in words."""
        self._ended, self._why = self._ended + 1, why
        if self._ended >= ORDERS:
            self._until_s = now_s + self._told_s
            self._told_s = min(2.0 * self._told_s, TOLD_MAX_S)

    def driven(self) -> None:
        """The vehicle has passed a node."""
        self._ended = 0
        self._told_s, self._until_s = TOLD_S, 0.0

    def problem(self, now_s: float) -> str:
        """The problem for people; empty while orders may be sent."""
        if now_s >= self._until_s:
            return ""
        why = self._why
        return f"it has ended {self._ended} orders one after the other, and has not driven: {why}"
