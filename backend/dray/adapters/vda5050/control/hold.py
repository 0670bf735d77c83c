"""Holding a vehicle: the master tells it to pause, and checks that it stands."""

from __future__ import annotations

from dray.adapters.vda5050.control.instant import ASK_STATE, InstantActions
from dray.adapters.vda5050.control.view import VehicleView
from dray.adapters.vda5050.profile import Profile

PAUSE, GO_ON = "startPause", "stopPause"


STANDS_S = 5.0
"""Seconds in which a vehicle brakes to a stand and reports it."""


class Holding:
    """The hold of one vehicle.

    Args:
        profile: whether it can pause.
        view: the vehicle's messages.
        instant: its instant actions.

    Attributes:
        held: whether its agent wants it to stand.
        problem: why it does not stand; empty when it does.
    """

    def __init__(self, profile: Profile, view: VehicleView, instant: InstantActions) -> None:
        self._profile, self._view, self._instant = profile, view, instant
        self.held = False
        self.problem = ""
        self._held_s = 0.0
        self._gone_on_s = float("-inf")
        self._has_asked = False
        """Whether its state was requested, after silence past the time to stand."""

    def hold(self, now_s: float) -> None:
        """Make it stand; twice is harmless."""
        if not self.held:
            self.held, self._held_s, self._has_asked = True, now_s, False
            self._say(PAUSE, GO_ON, now_s)

    def go_on(self, now_s: float) -> None:
        """Let it resume; harmless when it is not held."""
        if self.held:
            self.held, self.problem, self._gone_on_s = False, "", now_s
            self._say(GO_ON, PAUSE, now_s)

    def is_held(self, now_s: float) -> bool:
        """Whether it stands for its agent, or was released only just now."""
        return self.held or now_s < self._gone_on_s + STANDS_S

    def tick(self, now_s: float) -> None:
        """Check whether it stands."""
        view = self._view
        if not self.held or now_s < self._held_s + STANDS_S:
            return
        if view.heard_s < self._held_s + STANDS_S:
            if not self._has_asked:
                self._has_asked = True
                self._instant.say(ASK_STATE, now_s)
            return
        obeys = "it does not pause" if self._profile.pause else "it does not stop"
        self.problem = f"{obeys}: it moves although it was told to stand" if view.is_moving else ""

    def _say(self, wanted: str, other: str, now_s: float) -> None:
        if self._profile.pause:
            self._instant.forget(other)
            self._instant.say(wanted, now_s)
