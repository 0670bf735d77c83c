"""A vehicle's battery: its consumption and its charging. Pure arithmetic in closed form.

Spending is linear in metres and seconds. Charging follows the usual curve of a lithium battery (constant current,
then constant voltage), in the shape of `VehicleType`. It has full power up to a bend; then power falls linearly with
the level, to a tenth at full. In that second part the level approaches a point beyond full exponentially, so it
reaches full in finite time.

The charging power is the part that reaches the battery: the charger also feeds the vehicle's computers.
"""

from __future__ import annotations

from collections.abc import Callable
from math import exp, log

from dray.plant.model import VehicleType

SECONDS_PER_HOUR = 3600.0

LEFT_AT_FULL = 0.1
"""The part of the full charging power that is left when the battery is full (`VehicleType.charge_w`)."""


HALVINGS = 50
"""Number of bisections that find when the battery ends on a ride of minutes: far below a nanosecond."""


class Battery:
    """The battery of one type of vehicle. Levels are fractions from 0, empty, to 1, full."""

    __slots__ = (
        "_bend_frac",
        "_capacity_wh",
        "_charge_per_s",
        "_decay_per_s",
        "_fall",
        "_idle_per_s",
        "_metre_empty",
        "_metre_loaded",
    )

    def __init__(self, vehicle_type: VehicleType) -> None:
        capacity_wh = vehicle_type.battery_wh
        self._capacity_wh = capacity_wh
        self._idle_per_s = vehicle_type.idle_w / SECONDS_PER_HOUR / capacity_wh
        self._metre_empty = vehicle_type.drive_wh_per_m / capacity_wh
        self._metre_loaded = vehicle_type.loaded_wh_per_m / capacity_wh
        self._charge_per_s = vehicle_type.charge_w / SECONDS_PER_HOUR / capacity_wh
        self._bend_frac = vehicle_type.charge_taper_frac
        taper_frac = 1.0 - self._bend_frac
        self._fall = (1.0 - LEFT_AT_FULL) / taper_frac if taper_frac > 0.0 else 0.0
        self._decay_per_s = self._fall * self._charge_per_s

    def spent_frac(self, metres: float, loaded: bool, seconds: float) -> float:
        """The part of the level that driving or standing uses."""
        per_metre = self._metre_loaded if loaded else self._metre_empty
        return metres * per_metre + seconds * self._idle_per_s

    def lasts_s(self, level_frac: float) -> float:
        """How long a standing vehicle's battery lasts; infinity when standing costs nothing."""
        return level_frac / self._idle_per_s if self._idle_per_s > 0.0 else float("inf")

    def charged_frac(self, level_frac: float, seconds: float) -> float:
        """The level after charging from `level_frac` for `seconds`; at most 1."""
        if level_frac < self._bend_frac:
            to_bend_s = (self._bend_frac - level_frac) / self._charge_per_s
            if seconds <= to_bend_s:
                return level_frac + seconds * self._charge_per_s
            level_frac, seconds = self._bend_frac, seconds - to_bend_s
        if not self._fall:
            return 1.0
        goal_frac = self._bend_frac + 1.0 / self._fall
        return min(goal_frac - (goal_frac - level_frac) * exp(-self._decay_per_s * seconds), 1.0)

    def charging_s(self, level_frac: float, to_frac: float = 1.0) -> float:
        """Duration of charging from `level_frac` to `to_frac`; 0 when it is there already."""
        if to_frac <= level_frac:
            return 0.0
        flat_s = max(min(to_frac, self._bend_frac) - level_frac, 0.0) / self._charge_per_s
        if to_frac <= self._bend_frac:
            return flat_s
        goal_frac = self._bend_frac + 1.0 / self._fall
        begin_frac = max(level_frac, self._bend_frac)
        return flat_s + log((goal_frac - begin_frac) / (goal_frac - to_frac)) / self._decay_per_s


def runs_out_s(level_frac: Callable[[float], float], begin_s: float, end_s: float) -> float:
    """When a battery is empty, in seconds from where its times count.

    Args:
        level_frac: its level at a time in between; it only falls.
        begin_s: not after the end of the battery.
        end_s: the battery is empty then.
    """
    for _ in range(HALVINGS):
        middle_s = 0.5 * (begin_s + end_s)
        if level_frac(middle_s) > 0.0:
            begin_s = middle_s
        else:
            end_s = middle_s
    return end_s
