"""Checks whether a charging vehicle gains charge: a vehicle at a dead charger would wait there for ever, and nobody would be told."""

from __future__ import annotations

from dray.plant.model import VehicleType

RISE_FRAC = 0.009
"""Least gain that counts: nearly a percent, since levels are reported in whole percent, and flicker by less."""

PATIENCE_S, TIMES = 300.0, 12.0
"""The allowed time of that gain: this factor times the time at full power, plus these seconds. Some vehicles report steps of 10 %."""

HOUR_S = 3600.0


class ChargeWatch:
    """The gain of one vehicle's battery at a charger.

    Above `charge_taper_frac` batteries are balanced for as long as they need: nothing is expected of them there.

    Args:
        kind: the vehicle's type in the plant.
    """

    def __init__(self, kind: VehicleType) -> None:
        self._taper_frac = kind.charge_taper_frac
        self._patience_s = PATIENCE_S + TIMES * RISE_FRAC * kind.battery_wh * HOUR_S / kind.charge_w
        self._from: tuple[float, float] | None = None
        """The last level that was a gain, and when it was reported; None while it does not charge."""

    def look(self, level_frac: float | None, now_s: float) -> str:
        """Check a new report.

        Args:
            level_frac: its reported level; None while it has nothing to charge for, or does not report its level.
            now_s: the present time.

        Returns:
            The problem in words; empty for none.
        """
        if level_frac is None or level_frac >= self._taper_frac:
            self._from = None
            return ""
        if self._from is None or level_frac >= self._from[0] + RISE_FRAC:
            self._from = level_frac, now_s
        for_s = now_s - self._from[1]
        if for_s < self._patience_s:
            return ""
        return f"it is at its charger, and its battery level has not risen for {self._patience_s:.0f} s"
