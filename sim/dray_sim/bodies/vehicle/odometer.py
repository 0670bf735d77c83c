"""A vehicle's metres and seconds so far, for the report of a run."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from enum import StrEnum
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from dray_sim.bodies.vehicle.power import Power
    from dray_sim.bodies.vehicle.travel import Travel


class Activity(StrEnum):
    """The activities among which a vehicle's time is divided; one at every moment."""

    MOVING_EMPTY = "moving_empty"
    MOVING_LOADED = "moving_loaded"
    HANDLING = "handling"
    """Loading or unloading."""
    WAITING = "waiting"
    """Waiting for the release of its way, or at a station for something to load."""
    CHARGING = "charging"
    HELD = "held"
    """Stopped by a person, a breakdown or an empty battery."""
    OFF = "off"
    """Without power."""
    IDLE = "idle"


@dataclass(slots=True)
class Odometer:
    """Sums that only ever grow."""

    empty_m: float = 0.0
    loaded_m: float = 0.0
    seconds: dict[Activity, float] = field(default_factory=lambda: dict.fromkeys(Activity, 0.0))

    @property
    def metres_m(self) -> float:
        """All metres."""
        return self.empty_m + self.loaded_m

    def copy(self) -> Odometer:
        """The same sums, independent from now on."""
        return Odometer(self.empty_m, self.loaded_m, dict(self.seconds))

    def move(self, metres: float, seconds: float, loaded: bool) -> None:
        """Add a stretch of way."""
        if loaded:
            self.loaded_m += metres
            self.seconds[Activity.MOVING_LOADED] += seconds
        else:
            self.empty_m += metres
            self.seconds[Activity.MOVING_EMPTY] += seconds

    def stand(self, activity: Activity, seconds: float) -> None:
        """Add time without movement."""
        self.seconds[activity] += seconds

    def add(
        self, travel: Travel, power: Power, standing: Callable[[], Activity], now_s: float, *, loaded: bool
    ) -> Odometer:
        """Add the time since the power was settled.

        Args:
            travel: how far the vehicle has come.
            power: settled at some earlier moment.
            standing: the activity when it does not move.
            now_s: until when.
            loaded: whether something is on board.

        Returns:
            This odometer.
        """
        begin_s = power.settled_s
        stands_s = min(max(travel.moves_until_s, begin_s), now_s)
        if stands_s > begin_s:
            metres = max(travel.driven_m(now_s) - power.settled_m, 0.0)
            self.move(metres, stands_s - begin_s, loaded=loaded)
        if now_s > stands_s:
            self.stand(standing(), now_s - stands_s)
        return self
