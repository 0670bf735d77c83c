"""The handshake at a machine's dock, as a table of states.

    who        does                              signal
    vehicle    stands at the dock and asks
    agent      tells the controller              dock_permit on
    controller makes the dock safe               dock_ready on
    agent      lets the vehicle load or unload
    vehicle    does, and reports it
    agent      withdraws the permit              dock_permit off
    controller resumes work                      dock_ready off

Only then is the dock free for another vehicle. While the connection is broken nobody is let in, and one inside finishes. Whether the controller
still shows ready for the vehicle before is unknown then: the next one waits until the controller has said that it is not ready. A controller must not let machines move while `dock_permit` is on, or while `alive` stands still.
"""

from __future__ import annotations

from enum import StrEnum


class DockState(StrEnum):
    """The progress of the handshake."""

    SHUT = "shut"
    ASKED = "asked"
    """The controller was asked, and is not ready."""
    OPEN = "open"
    """A vehicle may load or unload."""
    CLOSING = "closing"
    """The permit is withdrawn, and the controller still shows ready, or may do so."""


class DockEvent(StrEnum):
    """An event of the handshake."""

    WANTED = "wanted"
    """A vehicle requests entry."""
    DONE = "done"
    """The vehicle has left, or no longer requests entry."""
    READY = "ready"
    NOT_READY = "not ready"
    LOST = "lost"
    """The controller is not connected, or its value is none."""


NEXT: dict[DockState, dict[DockEvent, DockState]] = {
    DockState.SHUT: {
        DockEvent.WANTED: DockState.ASKED,
        DockEvent.DONE: DockState.SHUT,
        DockEvent.READY: DockState.CLOSING,
        DockEvent.NOT_READY: DockState.SHUT,
        DockEvent.LOST: DockState.SHUT,
    },
    DockState.ASKED: {
        DockEvent.WANTED: DockState.ASKED,
        # It ends at once if the controller is known not to be ready.
        DockEvent.DONE: DockState.CLOSING,
        DockEvent.READY: DockState.OPEN,
        DockEvent.NOT_READY: DockState.ASKED,
        DockEvent.LOST: DockState.ASKED,
    },
    DockState.OPEN: {
        DockEvent.WANTED: DockState.OPEN,
        DockEvent.DONE: DockState.CLOSING,
        DockEvent.READY: DockState.OPEN,
        DockEvent.NOT_READY: DockState.ASKED,
        DockEvent.LOST: DockState.ASKED,
    },
    DockState.CLOSING: {
        # An earlier ready signal does not count: the next vehicle waits until it has ended, and comes anew.
        DockEvent.WANTED: DockState.CLOSING,
        DockEvent.DONE: DockState.CLOSING,
        DockEvent.READY: DockState.CLOSING,
        DockEvent.NOT_READY: DockState.SHUT,
        DockEvent.LOST: DockState.CLOSING,
    },
}
"""The next state for every event in every state, so that the dock is always in one of four."""


class DockHandshake:
    """The dock of one machine, for one vehicle at a time; others wait in order of arrival.

    Args:
        answers: whether the controller signals ready; otherwise it counts as ready when asked.

    Attributes:
        state: the progress of the handshake.
    """

    def __init__(self, *, answers: bool) -> None:
        self._answers = answers
        self._waiting: list[str] = []
        self._shows: bool | None = None
        """Whether the controller shows ready; None while that is unknown."""
        self.state = DockState.SHUT

    @property
    def vehicle(self) -> str:
        """The vehicle for which the controller is asked; empty for none."""
        return self._waiting[0] if self.state in (DockState.ASKED, DockState.OPEN) else ""

    @property
    def waiting(self) -> tuple[str, ...]:
        """The present vehicle and those that wait, in order."""
        return tuple(self._waiting)

    def want(self, vehicle: str) -> None:
        """A vehicle requests entry. Harmless when it waits already."""
        if vehicle not in self._waiting:
            self._waiting.append(vehicle)
        self._go_on()

    def done(self, vehicle: str) -> None:
        """A vehicle has left. Harmless when it did not wait."""
        was_first = self.vehicle == vehicle
        if vehicle in self._waiting:
            self._waiting.remove(vehicle)
        if was_first:
            self._enter(DockEvent.DONE)
        self._go_on()

    def ready(self, *, is_ready: bool) -> None:
        """The controller signals whether it is ready."""
        self._shows = is_ready
        self._enter(DockEvent.READY if is_ready else DockEvent.NOT_READY)
        self._go_on()

    def lost(self) -> None:
        """The controller is not connected any more, or sends no value."""
        self._shows = None
        self._enter(DockEvent.LOST)
        self._go_on()

    def _go_on(self) -> None:
        if self.state is DockState.CLOSING and (self._shows is False or not self._answers):
            self._enter(DockEvent.NOT_READY)
        if self._waiting and self.state is DockState.SHUT:
            self._enter(DockEvent.WANTED)
        if not self._answers and self.state is DockState.ASKED:
            self._enter(DockEvent.READY)

    def _enter(self, event: DockEvent) -> None:
        self.state = NEXT[self.state][event]
