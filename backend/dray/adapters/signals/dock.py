"""The handshake at a machine's dock, as a table of states.

    who        does                              signal
    vehicle    stands at the dock and asks
    agent      says so to the controller         dock_permit on
    controller makes the dock safe               dock_ready on
    agent      lets the vehicle load or unload
    vehicle    does, and says so
    agent      takes the permit back             dock_permit off
    controller works on                          dock_ready off

Only then is the dock anybody else's. A broken connection is as if the controller were not ready: nobody is let in who was not, and whoever
is in ends what it has begun. A controller that lets machines move while `dock_permit` is on, or while `alive` stands still, is wrong.
"""

from __future__ import annotations

from enum import StrEnum


class DockState(StrEnum):
    """How far it is."""

    SHUT = "shut"
    ASKED = "asked"
    """The controller was asked, and is not ready."""
    OPEN = "open"
    """A vehicle may load or unload."""
    CLOSING = "closing"
    """The permit is taken back, and the controller still shows ready."""


class DockEvent(StrEnum):
    """What happens."""

    WANTED = "wanted"
    """A vehicle is to be let in."""
    DONE = "done"
    """It is there no more, or is not to be let in."""
    READY = "ready"
    NOT_READY = "not ready"
    """The controller says so, or cannot be heard."""


NEXT: dict[DockState, dict[DockEvent, DockState]] = {
    DockState.SHUT: {
        DockEvent.WANTED: DockState.ASKED,
        DockEvent.DONE: DockState.SHUT,
        DockEvent.READY: DockState.CLOSING,
        DockEvent.NOT_READY: DockState.SHUT,
    },
    DockState.ASKED: {
        DockEvent.WANTED: DockState.ASKED,
        DockEvent.DONE: DockState.SHUT,
        DockEvent.READY: DockState.OPEN,
        DockEvent.NOT_READY: DockState.ASKED,
    },
    DockState.OPEN: {
        DockEvent.WANTED: DockState.OPEN,
        DockEvent.DONE: DockState.CLOSING,
        DockEvent.READY: DockState.OPEN,
        DockEvent.NOT_READY: DockState.ASKED,
    },
    DockState.CLOSING: {
        # The ready of before is nobody's: the next one waits until it has gone, and comes anew.
        DockEvent.WANTED: DockState.CLOSING,
        DockEvent.DONE: DockState.CLOSING,
        DockEvent.READY: DockState.CLOSING,
        DockEvent.NOT_READY: DockState.SHUT,
    },
}
"""Every event has its place in every state: whatever a controller says, the dock is in one of four."""


class DockHandshake:
    """The dock of one machine, for one vehicle at a time; others wait in the order in which they came.

    Args:
        answers: whether the controller says when it is ready; else it is as soon as it is asked.

    Attributes:
        state: how far it is.
    """

    def __init__(self, *, answers: bool) -> None:
        self._answers = answers
        self._waiting: list[str] = []
        self.state = DockState.SHUT

    @property
    def vehicle(self) -> str:
        """For whom the controller is asked; empty for nobody."""
        return self._waiting[0] if self.state in (DockState.ASKED, DockState.OPEN) else ""

    @property
    def waiting(self) -> tuple[str, ...]:
        """Who is there, or waits to be, in this order."""
        return tuple(self._waiting)

    def want(self, vehicle: str) -> None:
        """A vehicle is to be let in. Harmless when it waits already."""
        if vehicle not in self._waiting:
            self._waiting.append(vehicle)
        self._go_on()

    def done(self, vehicle: str) -> None:
        """A vehicle is there no more. Harmless when it did not wait."""
        was_first = self.vehicle == vehicle
        if vehicle in self._waiting:
            self._waiting.remove(vehicle)
        if was_first:
            self._enter(DockEvent.DONE)
        self._go_on()

    def ready(self, *, is_ready: bool) -> None:
        """The controller says whether it is."""
        self._enter(DockEvent.READY if is_ready else DockEvent.NOT_READY)
        self._go_on()

    def _go_on(self) -> None:
        if self._waiting and self.state is DockState.SHUT:
            self._enter(DockEvent.WANTED)
        if not self._answers and self.state is DockState.ASKED:
            self._enter(DockEvent.READY)
        if not self._answers and self.state is DockState.CLOSING:
            self._enter(DockEvent.NOT_READY)
            self._go_on()

    def _enter(self, event: DockEvent) -> None:
        self.state = NEXT[self.state][event]
