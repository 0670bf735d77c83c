"""A vehicle that takes no orders: each was refused as often as its profile allows, and none was shown in between.

One such order may be wrong. Two are a problem of the vehicle: it must win no tasks, and people must look. The problem ends by
itself, since only another order shows whether the vehicle takes orders again; it lasts twice as long each time.
"""

from __future__ import annotations

ORDERS = 2

TOLD_S, TOLD_MAX_S = 60.0, 600.0
"""Duration of the problem: at first, and at most."""


class Unwilling:
    """Counts the refused orders of one vehicle."""

    def __init__(self) -> None:
        self._refused = 0
        self._reason = ""
        self._told_s, self._until_s = TOLD_S, 0.0

    def refused(self, reason: str, now_s: float) -> None:
        """An order was given up, with the reason; empty where the vehicle gives none, though it may have before."""
        self._refused, self._reason = self._refused + 1, reason or self._reason
        if self._refused >= ORDERS:
            self._until_s = now_s + self._told_s
            self._told_s = min(2.0 * self._told_s, TOLD_MAX_S)

    def accepted(self) -> None:
        """The vehicle shows an order."""
        self._refused, self._reason = 0, ""
        self._told_s, self._until_s = TOLD_S, 0.0

    def problem(self, now_s: float) -> str:
        """The problem for people; empty while orders may be sent."""
        if now_s >= self._until_s:
            return ""
        why = self._reason or "it does not say why"
        return f"it has refused {self._refused} orders one after the other: {why}"
