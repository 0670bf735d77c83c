"""A simulated controller's watch over `alive`: while it stands still, nobody hears what the controller does."""

from __future__ import annotations

from dray.adapters.signals.signal import Value
from dray.ports import Clock

STILL_S = 3.0
"""Real seconds without a change after which `alive` stands still."""


class Alive:
    """The time since the last change of `alive`.

    Args:
        clock: the plant's.
        still_s: time without a change after which it stands still (plant clock); infinite for a controller that does not look.
    """

    def __init__(self, clock: Clock, still_s: float) -> None:
        self._clock, self._still_s = clock, still_s
        self._value: Value | None = None
        self._changed_s = clock.now_s()

    def beat(self, value: Value) -> None:
        """A value was written."""
        if value != self._value:
            self._value, self._changed_s = value, self._clock.now_s()

    @property
    def stands(self) -> bool:
        """Whether it stands still."""
        return self._clock.now_s() - self._changed_s > self._still_s
