"""The dock of a simulated controller: on a permit it opens for the named vehicle after some seconds, and it shuts without."""

from __future__ import annotations

from collections.abc import Callable

from dray.body import CloseDock, OpenDock
from dray.ports import Body
from dray_sim.bodies.docks import WHATEVER

LOOK_S = 1.0
"""Interval between two looks of a controller at its inputs."""

READY_AFTER_S = 4.0
"""Time that a dock takes to open."""


class ControlledDock:
    """The dock of a machine or a storage with a controller.

    Args:
        body: the machine or storage.
        now_s: the plant's time.
        show: is given whether it is ready, at each change.
    """

    def __init__(self, body: Body, now_s: float, show: Callable[[bool], None]) -> None:
        self._body, self._show = body, show
        self._open_for, self._open_at_s = "", now_s + READY_AFTER_S

    def look(self, vehicle: str, now_s: float) -> None:
        """Open for this vehicle, or shut without one.

        Args:
            vehicle: the vehicle with a permit; empty for none.
            now_s: the plant's time.
        """
        if self._open_for and vehicle != self._open_for:
            self._body.instruct(CloseDock(vehicle=self._open_for))
            self._open_for = ""
            self._show(False)
        elif not vehicle or self._open_for:
            self._open_at_s = now_s + READY_AFTER_S
        elif now_s >= self._open_at_s:
            item, quantity = WHATEVER
            self._body.instruct(OpenDock(vehicle=vehicle, item=item, quantity=quantity))
            self._open_for = vehicle
            self._show(True)

    def lose_power(self, now_s: float) -> None:
        """It has shut; the body has done so by itself."""
        self._open_for, self._open_at_s = "", now_s + READY_AFTER_S
        self._show(False)
