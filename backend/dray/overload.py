"""Overload: the vehicles cannot carry the demand. One rule, for the gateway's alert and for the verdict on a run.

Announcements reach all vehicles in the end, and a free vehicle takes waiting work. So a transport that has waited long, without
another known reason, has found no vehicle. Many such transports at once are no coincidence.
"""

from __future__ import annotations

from collections.abc import Iterable

WAITED_S = 300.0
"""Factory seconds without a vehicle: three transports of a plant that keeps up take less."""

LEAST = 3
"""Minimum number of such transports."""

PER_VEHICLE = 0.25
"""Minimum number of such transports per vehicle; the larger minimum counts."""

OVER_FRAC = 0.5
"""The overload ends at this fraction of the minimum, so that the alert does not flicker."""


class Overload:
    """Detects whether a plant is overloaded.

    Attributes:
        lasts: whether it was overloaded at the last look.
        waiting: transports that had waited too long at the last look.
    """

    def __init__(self) -> None:
        self.lasts = False
        self.waiting = 0

    def look(self, waited_s: Iterable[float], vehicles: int) -> bool:
        """Look at the plant's demand.

        Args:
            waited_s: seconds since the announcement (factory time), for each transport without a vehicle or another problem.
            vehicles: number of vehicles available to carry them.

        Returns:
            Whether the demand exceeds what these vehicles can carry.
        """
        self.waiting = sum(each_s > WAITED_S for each_s in waited_s)
        most = max(LEAST, PER_VEHICLE * vehicles)
        self.lasts = self.waiting >= (OVER_FRAC * most if self.lasts else most)
        return self.lasts
