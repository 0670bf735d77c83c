"""The way of a body's reports to its agent: in order, and never inside an instruction.

A body says things while it is in the middle of changing its own state. The agent may answer with an instruction, so
reports go out when the change is complete. After a callback of the clock that is at once; after an instruction it is
in a callback at the same instant.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable

from dray.body import Report
from dray.ports import Clock


class Reporter:
    """Holds a body's reports until they may be delivered. Reports without an attached agent are lost, as on a wire."""

    __slots__ = ("_asked", "_clock", "_mute", "_on_report", "_waiting")

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._waiting: deque[Report] = deque()
        """Bounded by what one instruction or one instant can cause: a handful."""
        self._on_report: Callable[[Report], None] | None = None
        self._asked = False
        self._mute = False

    def attach(self, on_report: Callable[[Report], None]) -> None:
        """Deliver to `on_report` from now on, instead of the earlier receiver."""
        self._on_report = on_report

    def say(self, report: Report) -> None:
        """Report this with the next `flush`; a mute body says nothing, and does not make up for it."""
        if not self._mute:
            self._waiting.append(report)

    def mute(self) -> None:
        """Drop all reports from now on, waiting ones included: the body has no power."""
        self._mute = True
        self._waiting.clear()

    def unmute(self) -> None:
        """Speak again."""
        self._mute = False

    def flush_soon(self) -> None:
        """Let everything said be heard at this instant, but after the caller has returned."""
        if self._waiting and not self._asked:
            self._asked = True
            self._clock.call_at(self._clock.now_s(), self._called)

    def flush(self) -> None:
        """Let everything said be heard now; for the end of a clock's callback."""
        while self._waiting:
            report = self._waiting.popleft()
            if self._on_report is not None:
                self._on_report(report)

    def _called(self) -> None:
        self._asked = False
        self.flush()
