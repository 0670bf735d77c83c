"""A vehicle's power in use: the battery level at any moment, and the call before the battery is empty.

`dray_sim.bodies.vehicle.battery` does the arithmetic; this module adds time and movement. The level is known for one
moment (`settled_s`). Later levels follow from it in closed form until something changes; then it is settled anew.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from dray.plant.model import VehicleType
from dray.ports import Clock
from dray_sim.bodies.vehicle.battery import Battery, runs_out_s
from dray_sim.bodies.vehicle.handling import Handling
from dray_sim.bodies.vehicle.travel import NEVER_S, Travel

EMPTY_FRAC = 1e-9
"""Below this the battery is empty: milliseconds of an idle vehicle, and far above rounding."""

WATCH_EXACT_S = 60.0
"""A battery that lasts longer is looked at again after half of that time. So a vehicle has a handful of open calls,
and not one for each time it has moved."""


class Power:
    """The battery of one vehicle, and whether it is switched on.

    Args:
        vehicle_type: its battery.
        level_frac: at the beginning.
        clock: the plant's clock.
        travel: how far the vehicle has come, and until when it moves.
        handling: the load on board.
        charging: whether it is fed at this moment.
        look: called when the battery may be empty; settles, and asks `is_spent`.

    Attributes:
        level_frac: as of `settled_s`, in 0..1.
        settled_s, settled_m: when that was, and how far the vehicle had come then.
        empty: it has given all that it had.
        off: the vehicle is switched off.
    """

    def __init__(
        self,
        vehicle_type: VehicleType,
        level_frac: float,
        clock: Clock,
        travel: Travel,
        handling: Handling,
        *,
        charging: Callable[[], bool],
        look: Callable[[], None],
    ) -> None:
        self.level_frac = level_frac
        self.settled_s = clock.now_s()
        self.settled_m = 0.0
        self.empty = False
        self.off = False
        self._battery = Battery(vehicle_type)
        self._clock, self._travel, self._handling = clock, travel, handling
        self._charging, self._tell = charging, look
        self._watch_s = NEVER_S
        """The next call that watches the battery; never after the battery is empty."""

    @property
    def is_spent(self) -> bool:
        """Whether there was nothing left when it was settled."""
        return self.level_frac <= EMPTY_FRAC

    @property
    def charging_s(self) -> float:
        """Time from the last settling until the battery is full (s)."""
        return self._battery.charging_s(self.level_frac)

    def level(self, now_s: float) -> float:
        """The battery at a time not after the next change of plan."""
        if self.off:
            return self.level_frac
        seconds = now_s - self.settled_s
        if self._charging():
            return self._battery.charged_frac(self.level_frac, seconds)
        metres = self._travel.driven_m(now_s) - self.settled_m
        spent_frac = self._battery.spent_frac(metres, bool(self._handling.load), seconds)
        return max(self.level_frac - spent_frac, 0.0)

    def settle(self, now_s: float) -> None:
        """Bring the level up to now."""
        self.level_frac = self.level(now_s)
        self.settled_s, self.settled_m = now_s, self._travel.driven_m(now_s)

    def watch(self) -> None:
        """See to it that a call comes not later than the battery is empty."""
        if self.empty or self.off or self._charging():
            return
        left_s = self._empties_at_s() - self.settled_s
        when_s = self.settled_s + (left_s if left_s <= WATCH_EXACT_S else left_s / 2.0)
        if self.settled_s + left_s < self._watch_s:
            self._watch_s = when_s
            self._clock.call_at(when_s, partial(self._look, when_s))

    def _empties_at_s(self) -> float:
        """When the battery is empty if the vehicle stands after its next node or stop."""
        begin_s = self.settled_s
        end_s = max(min(self._travel.next_at_s, self._travel.moves_until_s), begin_s)
        level_frac = self.level(end_s)
        if level_frac > 0.0:
            return end_s + self._battery.lasts_s(level_frac)
        return runs_out_s(self.level, begin_s, end_s)

    def _look(self, when_s: float) -> None:
        if when_s == self._watch_s:
            self._watch_s = NEVER_S
        if not (self.empty or self.off or self._charging()):
            self._tell()
